#include "fusion/motion/odometry_filter.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/motion/wheel_speeds.hpp"

namespace infuse::motion {
namespace {

constexpr Duration kMaxPredictionStep{50'000'000};     // maximum duration of one prediction
constexpr Duration kMinSteeringInterval{100'000'000};  // the errors are correlated: more samples
                                                       // add no information

template <class Range>
bool any_finite(const Range& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// Errors of its course last for a second, whatever its rate: more fixes do not measure it better.
double gnss_course_noise(const OdometryOptions& options, double interval) {
  constexpr double kUnchanged = 1, kMinInterval = 0.1;  // s
  return options.gnss_course_noise *
         std::sqrt(std::max(1.0, kUnchanged / std::max(interval, kMinInterval)));
}

/// A sample holds until the next: on average it is half an interval later than it is used.
double held_rate(double measured, double change, double interval) {
  return measured + 0.5 * interval * change;
}

}  // namespace

OdometryFilter::OdometryFilter(const OdometryOptions& options,
                               const geometry::TrajectoryOptions& trajectory)
    : options_(options),
      state_(options),
      trajectory_(trajectory, options.pose_interval),
      sources_(options),
      arbiter_(options) {}

void OdometryFilter::set_pose(const Eigen::Isometry3d& T_odom_vehicle,
                              const geometry::Matrix6& covariance) {
  state_.set_pose(T_odom_vehicle, covariance);
  trajectory_.clear();
}

void OdometryFilter::add(const WheelOdometry& sample) {
  if (measured_speeds(sample) == 0 && !std::isfinite(sample.yaw_rate) &&
      !std::isfinite(sample.steering_angle)) {
    ++invalid_samples_;
    return;
  }
  insert(sample.stamp - options_.wheel_delay, sample);
}

void OdometryFilter::add(const ImuSample& sample) {
  if (!any_finite(sample.angular_velocity) && !any_finite(sample.linear_acceleration)) {
    ++invalid_samples_;
    return;
  }
  insert(sample.stamp - options_.imu_delay, sample);
}

void OdometryFilter::add(const AngularVelocity& sample) {
  if (!std::isfinite(sample.value[2]) || !(sample.noise > 0)) {
    ++invalid_samples_;
    return;
  }
  insert(sample.stamp, sample);
}

void OdometryFilter::add(const GnssFix& fix) { insert(fix.stamp - options_.gnss_delay, fix); }

void OdometryFilter::mark(Stamp stamp, bool clone) { insert(stamp, PoseMark{stamp, clone}); }

void OdometryFilter::insert(Stamp stamp, const SampleQueue::Sample& sample) {
  switch (queue_.check(stamp, now_)) {
    case SampleQueue::StampCheck::kIsolated:
      ++invalid_samples_;
      return;
    case SampleQueue::StampCheck::kLate:
      ++late_;
      return;
    case SampleQueue::StampCheck::kClockStep:
      reset_clock();
      break;
    case SampleQueue::StampCheck::kInOrder:
      break;
  }
  if (queue_.full()) process_until(queue_.oldest());
  queue_.insert(stamp, sample);
  if (!std::holds_alternative<PoseMark>(sample)) process_until(queue_.newest() - options_.reorder);
}

void OdometryFilter::reset_clock() {
  queue_.clear();
  trajectory_.clear();
  state_.reset_motion(to_seconds(options_.max_silence));
  now_ = last_steering_stamp_ = Stamp::earliest();
  sources_.reset();
  gnss_position_check_.reset();
  course_doubt_ = 0;
  last_course_stamp_ = Stamp::earliest();
  yaw_rate_delay_.reset();
  imu_delay_.reset();
  last_relative_pose_.reset();
  arbiter_.reset();
  last_wheels_.reset();
  last_gnss_speed_stamp_ = Stamp::earliest();
  at_rest_since_ = Stamp::latest();
}

void OdometryFilter::flush() { process_until(Stamp::latest()); }

void OdometryFilter::process_until(Stamp until) {
  queue_.drain(until, [this](const SampleQueue::Entry& entry) { process(entry); });
}

void OdometryFilter::process(const SampleQueue::Entry& entry) {
  if (now_ == Stamp::earliest()) now_ = entry.stamp;
  advance(entry.stamp - now_);
  const double before = state_.speed();
  std::visit([this](const auto& sample) { update(sample); }, entry.sample);
  arbiter_.correct(state_.speed() - before);
  // A mark's pose is of exactly its time, however near the last one is.
  const bool marked = std::holds_alternative<PoseMark>(entry.sample);
  extend_trajectory(marked ? Duration::zero() : options_.pose_interval);
}

void OdometryFilter::advance(Duration ahead) {
  const bool bridged = sources_.speed_known(now_ + ahead) && sources_.rotation_known(now_ + ahead);
  if (ahead > options_.max_silence && !bridged) {
    state_.reset_motion(to_seconds(ahead));
    sources_.reset();
    gnss_position_check_.reset();  // where odometry led meanwhile is not known
    course_doubt_ = 0;
    at_rest_since_ = Stamp::latest();
    arbiter_.reset();
    last_wheels_.reset();
    now_ = now_ + ahead;
    return;
  }
  for (; ahead > kMaxPredictionStep; ahead -= kMaxPredictionStep) {
    state_.predict(to_seconds(kMaxPredictionStep));
    now_ = now_ + kMaxPredictionStep;
    if (!trajectory_.poses().empty())
      extend_trajectory(std::max(OdometryTrajectory::kPredictedInterval, options_.pose_interval));
  }
  state_.predict(to_seconds(ahead));
  now_ = now_ + ahead;
}

void OdometryFilter::update(const PoseMark& mark) {
  if (mark.clone) state_.clone_pose(mark.stamp);
}

void OdometryFilter::update(const WheelOdometry& sample) {
  if (measured_speeds(sample) > 0) update_wheel_speeds(sample);
  if (std::isfinite(sample.yaw_rate)) {
    const double change = yaw_rate_delay_.change_before(now_).z();  // without its noise
    yaw_rate_delay_.add(now_, {std::nan(""), std::nan(""), sample.yaw_rate});
    record(OdometrySource::kYawRate,
           state_.update_yaw_rate(held_rate(sample.yaw_rate, change, yaw_rate_delay_.interval()),
                                  change),
           &OdometryState::reset_rotation_covariance);
  }
  if (std::isfinite(sample.steering_angle) && now_ - last_steering_stamp_ >= kMinSteeringInterval) {
    if (state_.update_steering(sample.steering_angle)) last_steering_stamp_ = now_;
  }
}

void OdometryFilter::update(const ImuSample& sample) {
  const bool whole =
      options_.planar ? std::isfinite(sample.angular_velocity[2])
                      : std::all_of(sample.angular_velocity.begin(), sample.angular_velocity.end(),
                                    [](double v) { return std::isfinite(v); });
  if (whole) update_gyro(sample.angular_velocity, options_.gyro_noise);
  if (any_finite(sample.linear_acceleration)) state_.update_gravity(sample);
}

void OdometryFilter::update(const AngularVelocity& sample) {
  update_gyro(sample.value, sample.noise);
}

void OdometryFilter::update_gyro(const std::array<double, 3>& rate, double noise) {
  const Eigen::Map<const Eigen::Vector3d> measured(rate.data());
  const double change = imu_delay_.change_before(now_).z();  // without its noise
  imu_delay_.add(now_, measured);
  const double yaw = held_rate(rate[2], change, imu_delay_.interval());
  record(OdometrySource::kGyro, state_.update_gyro({rate[0], rate[1], yaw}, noise, change),
         &OdometryState::reset_rotation_covariance);
}

EstimatedParameter OdometryFilter::delay_of(OdometrySource rates) const {
  const bool gyro = rates == OdometrySource::kGyro;
  const SensorDelay& found = (gyro ? imu_delay_ : yaw_rate_delay_).found();
  if (found.usable()) return {found.value, found.sigma};
  return {0, gyro ? options_.imu_delay_sigma : options_.yaw_rate_delay_sigma};
}

// The state learns a delay sooner, but from changes of the rate whose noise draws it towards 0.
void OdometryFilter::use_found(OdometrySource rates) {
  const bool gyro = rates == OdometrySource::kGyro;
  if (!(gyro ? imu_delay_ : yaw_rate_delay_).newly_found()) return;
  state_.set_parameter(gyro ? OdometryState::kGyroDelay : OdometryState::kYawRateDelay,
                       delay_of(rates));
}

void OdometryFilter::update(const GnssFix& fix) {
  constexpr double kMinCourseSpeed = 3;  // m/s
  if (!fix.valid) return;
  if (const auto agrees = gnss_position_check_.check(fix, state_.T_odom_vehicle().translation(),
                                                     state_.parameter(OdometryState::kEastHeading));
      agrees && usable()) {
    record(OdometrySource::kGnssPosition, *agrees);
    if (!*agrees) return;
  }
  const double interval =
      last_course_stamp_ == Stamp::earliest() ? 1 : to_seconds(now_ - last_course_stamp_);
  if (std::isfinite(fix.course)) last_course_stamp_ = now_;
  if (std::isfinite(fix.speed)) update_gnss_speed(fix.speed);
  if (state_.speed() > kMinCourseSpeed) {
    if (std::isfinite(fix.course)) update_gnss_course(fix.course, interval);
  } else if (sources_.carries(OdometrySource::kGnssSpeed, now_) &&
             !sources_.rotation_known(now_, OdometrySource::kGnssCourse)) {
    // A gyro need not be limited: while a vehicle turned on the spot, its bias absorbed the turn.
    state_.update_slow_turn();
    sources_.hold(OdometrySource::kGnssCourse, now_);  // the limit stands in for the course
  }
}

void OdometryFilter::update_gnss_course(double course, double interval) {
  const double noise = gnss_course_noise(options_, interval);
  bool accepted = state_.update_gnss_course(course, noise);
  course_doubt_ += std::clamp(interval, 0.0, to_seconds(options_.max_gnss_silence));
  if (!accepted && course_doubt_ > to_seconds(kMaxGnssDoubt)) {
    state_.release_heading();
    accepted = state_.update_gnss_course(course, noise);
  }
  if (accepted) course_doubt_ = 0;
  record(OdometrySource::kGnssCourse, accepted);
}

const char* OdometryFilter::reason() const {
  if (now_ == Stamp::earliest()) return "no sample received yet";
  const bool lidar = sources_.carries(OdometrySource::kLidar, now_);
  if (!sources_.speed_known(now_)) {
    return lidar ? "no source of speed: the lidar's surroundings do not determine it"
                 : "no source of speed";
  }
  if (!sources_.rotation_known(now_)) {
    return lidar ? "no source of rotation: the lidar's surroundings do not determine it"
                 : "no source of rotation";
  }
  return "";
}

void OdometryFilter::extend_trajectory(Duration interval) {
  if (usable()) trajectory_.extend(state_, now_, interval);
}

OdometryReport OdometryFilter::report() const {
  OdometryReport report;
  report.wheel_scale = state_.parameter(OdometryState::kWheelScale);
  report.yaw_rate_bias = state_.parameter(OdometryState::kYawRateBias);
  for (size_t i = 0; i < 3; ++i) {
    report.gyro_bias[i] = state_.parameter(OdometryState::kGyroBias + static_cast<int>(i));
  }
  report.steering_zero = state_.parameter(OdometryState::kSteeringZero);
  report.steering_gain = state_.parameter(OdometryState::kSteeringGain);
  report.yaw_rate_delay = delay_of(OdometrySource::kYawRate);
  report.imu_delay = delay_of(OdometrySource::kGyro);
  report.gnss_delay = state_.parameter(OdometryState::kGnssDelay);
  report.speed = state_.speed();
  report.speed_sigma = state_.speed_sigma();
  report.yaw_rate_sigma = state_.yaw_rate_sigma();
  for (size_t i = 0; i < kOdometrySources; ++i) {
    const auto source = static_cast<OdometrySource>(i);
    report.sources[i] = sources_[source];
    report.carries[i] = sources_.carries(source, now_);
  }
  report.angular_velocity = state_.angular_velocity();
  report.standing = at_rest_since_ != Stamp::latest() &&
                    now_ - at_rest_since_ >= options_.standstill_after &&
                    std::abs(state_.speed()) < 2 * options_.standstill_speed;
  report.late = late_;
  report.outliers = outliers_;
  report.invalid_samples = invalid_samples_;
  return report;
}

}  // namespace infuse::motion

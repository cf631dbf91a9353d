#include "fusion/motion/odometry_filter.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::motion {
namespace {

constexpr Duration kMaxPredictionStep{50'000'000};  // maximum duration of one prediction
constexpr Duration kSlipAfter{100'000'000};         // of rejected wheels; then they are suspended
constexpr Duration kAgreeBefore{500'000'000};       // of agreement, before they are used again
constexpr double kWheelAgreement = 0.4;             // m/s
constexpr uint64_t kMaxLidarRejections = 3;         // in a row without another source of speed
constexpr Duration kMinSteeringInterval{100'000'000};  // the errors are correlated: more samples
                                                       // add no information

template <class Range>
bool any_finite(const Range& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

int measured_speeds(const WheelOdometry& sample) {
  const auto wheels = std::count_if(sample.wheel_speed.begin(), sample.wheel_speed.end(),
                                    [](double v) { return std::isfinite(v); });
  return static_cast<int>(wheels) + (std::isfinite(sample.speed) ? 1 : 0);
}

bool measures_speed(const WheelOdometry& sample) { return measured_speeds(sample) > 0; }

/// Smallest change of the speed of a wheel, m/s.
double smallest_change(const WheelOdometry& from, const WheelOdometry& to) {
  double smallest = std::abs(to.speed - from.speed);
  for (size_t i = 0; i < to.wheel_speed.size(); ++i) {
    smallest = std::fmin(smallest, std::abs(to.wheel_speed[i] - from.wheel_speed[i]));  // no NaN
  }
  return smallest;
}

/// Errors of a GNSS receiver's speed are correlated, so that samples at a high rate add little: one
/// sample at a low rate counts as the mean of those at a high rate, down to half the noise of a
/// fix. Interval in s.
double gnss_speed_noise(const OdometryOptions& options, double interval) {
  constexpr double kStatedInterval = 0.1, kLeast = 0.5;  // s; part of the stated noise
  if (interval <= kStatedInterval) return options.gnss_speed_noise;
  return options.gnss_speed_noise * std::max(kLeast, std::sqrt(kStatedInterval / interval));
}

/// Errors of its course last for a second, whatever its rate: more fixes do not measure it better.
double gnss_course_noise(const OdometryOptions& options, double interval) {
  constexpr double kUnchanged = 1, kMinInterval = 0.1;  // s
  return options.gnss_course_noise *
         std::sqrt(std::max(1.0, kUnchanged / std::max(interval, kMinInterval)));
}

/// What a sensor of angular rates would state now, and its noise, rad/s.
struct LateRate {
  double value, noise;
};

/// The rate goes on to change as it did. A sample holds until the next: on average it is half an
/// interval later than it is used. The noise of the change is left out, since the angle is its sum.
LateRate late_rate(double measured, double noise, double change, const EstimatedParameter& delay,
                   double interval) {
  return {measured + change * (delay.value + 0.5 * interval),
          std::hypot(noise, change * delay.sigma)};
}

/// Error along the path of a lidar's motion that contradicts the speed of wheels, m; 0 if it does
/// not.
double contradiction_along(const RelativePoseUpdate& update, double seconds) {
  const double error = update.error[3];
  const bool contradicts =
      !update.accepted && update.speed_measured && std::abs(error) > kWheelAgreement * seconds;
  return contradicts ? error : 0;
}

}  // namespace

OdometryFilter::OdometryFilter(const OdometryOptions& options,
                               const geometry::TrajectoryOptions& trajectory)
    : options_(options),
      state_(options),
      trajectory_(trajectory, options.pose_interval),
      sources_(options) {}

void OdometryFilter::set_pose(const Eigen::Isometry3d& T_odom_vehicle,
                              const geometry::Matrix6& covariance) {
  state_.set_pose(T_odom_vehicle, covariance);
  trajectory_.clear();
}

void OdometryFilter::add(const WheelOdometry& sample) {
  if (!measures_speed(sample) && !std::isfinite(sample.yaw_rate) &&
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
  yaw_rate_delay_.reset();
  imu_delay_.reset();
  last_relative_pose_.reset();
  speed_agreement_.reset();
  last_wheels_.reset();
  jumped_wheels_.reset();
  rest_refuted_ = false;
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
  std::visit([this](const auto& sample) { update(sample); }, entry.sample);
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
    at_rest_since_ = Stamp::latest();
    last_wheels_.reset();
    jumped_wheels_.reset();
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
  if (measures_speed(sample)) update_wheel_speeds(sample);
  if (std::isfinite(sample.yaw_rate)) {
    const EstimatedParameter delay = delay_of(OdometrySource::kYawRate);
    yaw_rate_delay_.add(now_, {std::nan(""), std::nan(""), sample.yaw_rate});
    const LateRate rate =
        late_rate(sample.yaw_rate, options_.yaw_rate_noise, yaw_rate_delay_.change().z(), delay,
                  yaw_rate_delay_.interval());
    record(OdometrySource::kYawRate, state_.update_yaw_rate(rate.value, rate.noise),
           &OdometryState::reset_rotation_covariance);
  }
  if (std::isfinite(sample.steering_angle) && now_ - last_steering_stamp_ >= kMinSteeringInterval) {
    if (state_.update_steering(sample.steering_angle)) last_steering_stamp_ = now_;
  }
}

// Wheels slip: where another source measures the speed, they do not overrule it by persistence.
void OdometryFilter::update_wheel_speeds(const WheelOdometry& sample) {
  const OdometrySource source =
      any_finite(sample.wheel_speed) ? OdometrySource::kWheels : OdometrySource::kSpeed;
  const bool checked = sources_.speed_known(now_, source);
  if (wheels_suspended_ && checked && !readmit_wheels(sample)) {
    record(source, false);
    at_rest_since_ = Stamp::latest();
    return;
  }
  wheels_suspended_ = false;
  const auto turns = [&](double v) { return std::abs(v) > options_.standstill_speed; };
  const bool at_rest = std::none_of(sample.wheel_speed.begin(), sample.wheel_speed.end(), turns) &&
                       !turns(sample.speed);
  rest_refuted_ = rest_refuted_ && at_rest;
  if (rest_refuted_ || (!checked && have_jumped(sample, at_rest))) {
    at_rest_since_ = Stamp::latest();
    return record(source, false);
  }
  if (!checked) detect_standstill(at_rest);
  const int used = state_.update_wheels(sample);
  const bool accepted = used >= 1;
  record(source, accepted, checked ? nullptr : &OdometryState::reset_speed_covariance);
  if (accepted && used < measured_speeds(sample)) sources_.reject_part(source);
  if (accepted) {
    last_wheels_ = sample;
    last_wheels_->stamp = now_;
  }
  if (checked) {
    detect_standstill(at_rest && accepted);
    const Stamp since = sources_[source].rejected_since;
    wheels_suspended_ = !accepted && now_ - since >= kSlipAfter;
    wheels_agree_since_ = Stamp::latest();
  }
}

// Wheels that jump, from how they turned when they were accepted last, slide or spin: no vehicle
// brakes or accelerates so fast (tyres on dry road hold 1.2 g). They are out until they jump back
// by more than half, or turn as before, for as long as a vehicle slides on ice at most (0.1 g).
// Wheels that rest after a jump are out until they turn: whether the vehicle stands is not known.
bool OdometryFilter::have_jumped(const WheelOdometry& sample, bool at_rest) {
  constexpr double kMaxAcceleration = 12, kIce = 1;  // m/s²
  constexpr double kUnseen = 1;                      // m/s; below it sensors of wheels see no teeth
  constexpr double kNoiseSigmas = 4;                 // beyond are 0.006 % of a Gaussian
  if (!last_wheels_) return false;
  const double noise = at_rest ? kUnseen : kNoiseSigmas * options_.wheel_noise;
  const double change = smallest_change(*last_wheels_, sample);
  const WheelOdometry& before = jumped_wheels_.value_or(*last_wheels_);
  const Stamp since = jumped_wheels_ ? jumped_since_ : now_;
  const auto possible = [&](Duration time) { return kMaxAcceleration * to_seconds(time) + noise; };
  const bool may_slide = at_rest || to_seconds(now_ - since) < std::abs(state_.speed()) / kIce;
  bool out = may_slide && change > possible(since - last_wheels_->stamp);
  if (out && jumped_wheels_) {
    out = smallest_change(before, sample) <= possible(now_ - before.stamp) ||
          change > 0.5 * smallest_change(*last_wheels_, before);
  }
  jumped_since_ = since;
  jumped_wheels_ = out ? std::optional(sample) : std::nullopt;
  if (out) jumped_wheels_->stamp = now_;
  return out;
}

bool OdometryFilter::readmit_wheels(const WheelOdometry& sample) {
  wheels_agree_since_ = state_.agrees(sample, kWheelAgreement) ? std::min(wheels_agree_since_, now_)
                                                               : Stamp::latest();
  return wheels_agree_since_ != Stamp::latest() && now_ - wheels_agree_since_ >= kAgreeBefore;
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

// Roll and pitch shake: their changes are noise.
void OdometryFilter::update_gyro(const std::array<double, 3>& rate, double noise) {
  const Eigen::Map<const Eigen::Vector3d> measured(rate.data());
  imu_delay_.add(now_, measured);
  const LateRate yaw = late_rate(rate[2], noise, imu_delay_.change().z(),
                                 delay_of(OdometrySource::kGyro), imu_delay_.interval());
  record(OdometrySource::kGyro,
         state_.update_gyro({rate[0], rate[1], yaw.value}, {noise, noise, yaw.noise}),
         &OdometryState::reset_rotation_covariance);
}

EstimatedParameter OdometryFilter::delay_of(OdometrySource rates) const {
  const bool gyro = rates == OdometrySource::kGyro;
  const SensorDelay& found = (gyro ? imu_delay_ : yaw_rate_delay_).found();
  if (found.usable()) return {found.value, found.sigma};
  return {0, gyro ? options_.imu_delay_sigma : options_.yaw_rate_delay_sigma};
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
    if (std::isfinite(fix.course)) {
      record(OdometrySource::kGnssCourse,
             state_.update_gnss_course(fix.course, gnss_course_noise(options_, interval)));
    }
  } else if (sources_.carries(OdometrySource::kGnssSpeed, now_) &&
             !sources_.rotation_known(now_, OdometrySource::kGnssCourse)) {
    // A gyro need not be limited: while a vehicle turned on the spot, its bias absorbed the turn.
    state_.update_slow_turn();
    sources_.hold(OdometrySource::kGnssCourse, now_);  // the limit stands in for the course
  }
}

void OdometryFilter::update_gnss_speed(double measured) {
  const double interval =
      last_gnss_speed_stamp_ == Stamp::earliest() ? 0 : to_seconds(now_ - last_gnss_speed_stamp_);
  const double noise = gnss_speed_noise(options_, interval);
  last_gnss_speed_stamp_ = now_;
  bool accepted = state_.update_gnss_speed(measured, noise);
  if (!accepted && wheels_slip(measured)) {
    wheels_suspended_ = true;
    wheels_agree_since_ = Stamp::latest();
    const Eigen::Isometry3d T_odom_before = state_.T_odom_vehicle();
    state_.release_acceleration(to_seconds(now_ - speed_agreement_->stamp));
    accepted = state_.update_gnss_speed(measured, noise);
    // The slip has grown since the speeds agreed.
    trajectory_.correct_since(speed_agreement_->stamp, now_,
                              geometry::log(state_.T_odom_vehicle() * T_odom_before.inverse()));
  }
  record(OdometrySource::kGnssSpeed, accepted);
  if (!accepted) return;
  last_gnss_speed_ = measured;
  const double speed = std::abs(state_.speed());
  if (std::abs(measured - speed) < noise) speed_agreement_ = {now_, measured, speed};
}

// Wheels and receiver disagree, and nothing else measures the speed: wrong is the one whose speed
// has changed more since they agreed.
bool OdometryFilter::wheels_slip(double gnss_speed) const {
  if (!speed_agreement_ || wheels_suspended_ || !has_wheels() ||
      sources_.measures_speed(OdometrySource::kLidar, now_) ||
      now_ - speed_agreement_->stamp > options_.max_gnss_silence) {
    return false;
  }
  return std::abs(std::abs(state_.speed()) - speed_agreement_->filter) >
         std::abs(gnss_speed - speed_agreement_->gnss);
}

void OdometryFilter::add(const RelativePose& pose) {
  RelativePoseUpdate result = state_.update_relative_pose(pose, true);
  if (!result.known) {
    ++late_;
    return;
  }
  const double seconds = to_seconds(pose.to - pose.from);
  const double contradiction = contradiction_along(result, seconds);
  if (!result.accepted && result.informative && believe_lidar(pose, result)) {
    const bool wheels = has_wheels();
    const bool slip = wheels && contradiction != 0;
    if (slip) {
      wheels_suspended_ = true;
      wheels_agree_since_ = Stamp::latest();
    }
    state_.release_rotation(pose.from, now_);
    // Where the rotation explains it, wheels still know the speed, which the lidar may not show.
    if (wheels && !slip) result = state_.update_relative_pose(pose, true);
    if (!result.accepted) {
      state_.release_speed(pose.from, now_);
      result = state_.update_relative_pose(pose, wheels);
    }
  }
  last_relative_pose_ = {pose.to, geometry::log(pose.T_from_to) / seconds, contradiction};
  sources_.add(OdometrySource::kLidar, result.accepted, now_, result.speed_measured,
               result.rotation_measured);
  outliers_ += result.accepted ? 0 : 1;
  if (result.accepted && result.rotation_measured) {
    yaw_rate_delay_.add(pose);
    imu_delay_.add(pose);
  }
  if (result.accepted && usable()) trajectory_.correct(pose, result, state_, now_);
}

// The motion contradicts the lidar. Without wheels the motion is a guess, and the lidar is right if
// a vehicle can brake and turn from what it measured before to what it measures now; what is
// further is believed when it goes on. Wheels slip, but registration errs in rotation too: where
// the rotation agrees, the lidar is right. Wheels slip for many sweeps, and a registration errs to
// and fro, as at a tunnel's portal: the second contradiction in the same direction is believed. So
// is the first where roll and pitch changed too, which wheels do not measure. A receiver that is
// nearer to the speed of the others decides against the lidar.
bool OdometryFilter::believe_lidar(const RelativePose& pose,
                                   const RelativePoseUpdate& update) const {
  constexpr double kMaxRotationError = 0.01, kMaxTiltError = 0.005;  // rad
  constexpr double kMaxAcceleration = 12, kMaxTurnAcceleration = 6;  // m/s², rad/s²
  constexpr double kMaxGnssDifference = 3;                           // m/s
  constexpr double kMaxStepError = 0.3, kMaxTurnError = 0.05;        // m, rad, of the lidar
  const bool gnss = sources_.carries(OdometrySource::kGnssSpeed, now_);
  const bool follows = last_relative_pose_ && last_relative_pose_->to == pose.from;
  const double seconds = to_seconds(pose.to - pose.from);
  if (has_wheels()) {
    // A yaw rate says nothing of roll and pitch.
    const bool gyros = sources_.carries(OdometrySource::kGyro, now_);
    const double rotation = gyros ? update.error.head<3>().norm() : std::abs(update.error[2]);
    if (rotation > kMaxRotationError) return false;
    const bool shaken = update.error.head<2>().norm() > kMaxTiltError;
    const double contradiction = contradiction_along(update, seconds);
    const bool again = follows && contradiction * last_relative_pose_->contradiction > 0;
    if (contradiction != 0 && !again && !shaken) return false;
  } else if (follows) {
    const geometry::Vector6 change =
        geometry::log(pose.T_from_to) / seconds - last_relative_pose_->twist;
    const bool contradicted = gnss && std::abs(pose.T_from_to.translation().norm() / seconds -
                                               *last_gnss_speed_) > kMaxGnssDifference;
    if (!contradicted &&
        change.tail<3>().norm() < kMaxAcceleration * seconds + kMaxStepError / seconds &&
        change.head<3>().norm() < kMaxTurnAcceleration * seconds + kMaxTurnError / seconds) {
      return true;
    }
  }
  if (!gnss) {
    return has_wheels() ||
           sources_[OdometrySource::kLidar].rejected_in_a_row + 1 >= kMaxLidarRejections;
  }
  const double speed = pose.T_from_to.translation().norm() / seconds;
  return std::abs(speed - *last_gnss_speed_) <
         std::abs(std::abs(state_.speed()) - *last_gnss_speed_);
}

void OdometryFilter::record(OdometrySource source, bool accepted,
                            void (OdometryState::*reset_covariance)()) {
  const Stamp last = sources_[source].last_accepted;
  sources_.add(source, accepted, now_);
  if (accepted) return;
  ++outliers_;
  if (reset_covariance == nullptr || last == Stamp::earliest() ||
      now_ - last <= options_.max_silence) {
    return;
  }
  (state_.*reset_covariance)();
  // A vehicle that turns, for more than a sample or two, does not stand. How it moves, wheels at
  // rest do not say.
  if (reset_covariance != &OdometryState::reset_rotation_covariance) return;
  if (now_ - sources_[source].rejected_since < options_.max_silence / 2) return;
  if (at_rest_since_ == Stamp::latest()) return;
  rest_refuted_ = true;
  state_.reset_speed_covariance();
  at_rest_since_ = Stamp::latest();
}

void OdometryFilter::detect_standstill(bool at_rest) {
  if (!at_rest) {
    at_rest_since_ = Stamp::latest();
  } else {
    at_rest_since_ = std::min(at_rest_since_, now_);
    if (now_ - at_rest_since_ >= options_.standstill_after) state_.update_standstill();
  }
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

// The part of `OdometryFilter` that uses samples of the speed: what contradicts is judged first.
#include <algorithm>
#include <cmath>

#include "fusion/motion/odometry_filter.hpp"
#include "fusion/motion/wheel_speeds.hpp"

namespace infuse::motion {
namespace {

/// Errors of a GNSS receiver's speed are correlated, so that samples at a high rate add little: one
/// sample at a low rate counts as the mean of those at a high rate, down to half the noise of a
/// fix. Interval in s.
double gnss_speed_noise(const OdometryOptions& options, double interval) {
  constexpr double kStatedInterval = 0.1, kLeast = 0.5;  // s; part of the stated noise
  if (interval <= kStatedInterval) return options.gnss_speed_noise;
  return options.gnss_speed_noise * std::max(kLeast, std::sqrt(kStatedInterval / interval));
}

OdometrySource source_of(const WheelOdometry& sample) {
  const bool wheels = std::any_of(sample.wheel_speed.begin(), sample.wheel_speed.end(),
                                  [](double v) { return std::isfinite(v); });
  return wheels ? OdometrySource::kWheels : OdometrySource::kSpeed;
}

}  // namespace

// Wheels that lock, slip or spin change their speed at once, or contradict other sources. How long
// they slide at most where nothing else measures the speed is known, not how long they rest.
void OdometryFilter::update_wheel_speeds(const WheelOdometry& sample) {
  constexpr double kIce = 1;     // m/s²: the least that a sliding vehicle brakes by, 0.1 g
  constexpr double kUnseen = 1;  // m/s; below it sensors of wheels see no teeth
  const OdometrySource source = source_of(sample);
  const bool checked = sources_.speed_known(now_, source);
  const bool at_rest = is_at_rest(sample, options_.standstill_speed);
  const auto [error, sigma] = state_.speed_error(sample);
  SpeedArbiter::Claim claim{now_, state_.speed() + error, error, sigma};
  if (last_wheels_) {
    const bool rests = at_rest || is_at_rest(*last_wheels_, options_.standstill_speed);
    claim.jump = SpeedArbiter::impossible(smallest_change(*last_wheels_, sample),
                                          to_seconds(now_ - last_wheels_->stamp),
                                          rests ? kUnseen : kGateSigmas * options_.wheel_noise);
  }
  last_wheels_ = sample;
  last_wheels_->stamp = now_;
  const auto slides = Duration(static_cast<int64_t>(1e9 * std::abs(state_.speed()) / kIce));
  arbiter_.add(source, claim, at_rest || checked ? Duration::max() : slides);
  if (arbiter_.is_out(source)) {
    at_rest_since_ = Stamp::latest();
    return record(source, false);
  }
  if (!checked) detect_standstill(at_rest);
  const int used = state_.update_wheels(sample);
  const bool accepted = used >= 1;
  record(source, accepted, checked ? nullptr : &OdometryState::reset_speed_covariance);
  if (accepted && used < measured_speeds(sample)) sources_.reject_part(source);
  if (!checked) return;
  detect_standstill(at_rest && accepted);
  if (!accepted) arbiter_.judge(source);
}

void OdometryFilter::update_gnss_speed(double measured) {
  constexpr OdometrySource kSource = OdometrySource::kGnssSpeed;
  const double interval =
      last_gnss_speed_stamp_ == Stamp::earliest() ? 0 : to_seconds(now_ - last_gnss_speed_stamp_);
  const double noise = gnss_speed_noise(options_, interval);
  last_gnss_speed_stamp_ = now_;
  const auto [error, sigma] = state_.gnss_speed_error(measured, noise);
  arbiter_.add(kSource, {now_, state_.speed() + error, error, sigma}, kMaxGnssDoubt);
  if (arbiter_.is_out(kSource)) return record(kSource, false);
  bool accepted = state_.update_gnss_speed(measured, noise);
  const Stamp agreed = arbiter_.agreement().stamp;
  if (!accepted && arbiter_.judge(kSource) && agreed != Stamp::earliest()) {
    const Eigen::Isometry3d T_odom_before = state_.T_odom_vehicle();
    state_.release_acceleration(to_seconds(now_ - agreed));
    accepted = state_.update_gnss_speed(measured, noise);
    // What slips has done so since the speeds agreed.
    trajectory_.correct_since(agreed, now_,
                              geometry::log(state_.T_odom_vehicle() * T_odom_before.inverse()));
  }
  record(kSource, accepted);
}

void OdometryFilter::add(const RelativePose& pose) {
  const double before = state_.speed();
  RelativePoseUpdate result = state_.update_relative_pose(pose, true);
  if (!result.known) {
    ++late_;
    return;
  }
  claim_speed(pose, result, before);
  if (!result.accepted && result.informative && believe_lidar(result)) {
    state_.release_rotation(pose.from, now_);
    // Where the rotation explains it, wheels still know the speed, which the lidar may not show.
    const bool wheels = has_wheels();
    if (wheels) result = state_.update_relative_pose(pose, true);
    if (!result.accepted && !wheels_measure_speed()) {
      state_.release_speed(pose.from, now_);
      result = state_.update_relative_pose(pose, wheels);
    }
  }
  arbiter_.correct(state_.speed() - before);
  sources_.add(OdometrySource::kLidar, result.accepted, now_, result.speed_measured,
               result.rotation_measured);
  outliers_ += result.accepted ? 0 : 1;
  if (result.accepted && result.rotation_measured) {
    yaw_rate_delay_.add(pose);
    imu_delay_.add(pose);
    use_found(OdometrySource::kYawRate);
    use_found(OdometrySource::kGyro);
  }
  if (result.accepted && usable()) trajectory_.correct(pose, result, state_, now_);
}

// A registration errs for a sweep; where others measure the speed, for longer: as at a tunnel's
// portal. Where a vehicle pitches or rolls, its points move by what the wheels do not measure.
void OdometryFilter::claim_speed(const RelativePose& pose, const RelativePoseUpdate& update,
                                 double state_speed) {
  constexpr double kMaxStepError = 0.3;  // m, of the lidar
  const double seconds = to_seconds(pose.to - pose.from);
  const geometry::Vector6 twist = geometry::log(pose.T_from_to) / seconds;
  const bool follows = last_relative_pose_ && last_relative_pose_->to == pose.from;
  const geometry::Vector6 before = follows ? last_relative_pose_->twist : twist;
  last_relative_pose_ = {pose.to, twist};
  if (!update.speed_measured) return;
  const double speed = options_.moves_forward ? twist[3] : twist.tail<3>().norm();
  const double error = options_.moves_forward ? update.error[3] / seconds : speed - state_speed;
  const double tilt = options_.planar ? 0 : update.error.head<2>().norm() / seconds;
  SpeedArbiter::Claim claim{now_, speed, error,
                            std::hypot(update.speed_sigma, options_.wheelbase * tilt)};
  const geometry::Vector6 change = twist - before;
  const double of_points = change.tail<3>().norm() + options_.wheelbase * change.head<3>().norm();
  claim.jump = SpeedArbiter::impossible(of_points, seconds, kMaxStepError / seconds);
  const bool checked = sources_.speed_known(now_, OdometrySource::kLidar);
  arbiter_.add(OdometrySource::kLidar, claim, checked ? options_.max_silence : Duration::zero());
}

// Where others complete the motion, they measure its rotation better than a lidar that contradicts.
bool OdometryFilter::believe_lidar(const RelativePoseUpdate& update) {
  constexpr double kMaxRotationError = 0.01;  // rad
  if (has_wheels()) {
    // A yaw rate says nothing of roll and pitch.
    const bool gyros = sources_.carries(OdometrySource::kGyro, now_);
    const double rotation = gyros ? update.error.head<3>().norm() : std::abs(update.error[2]);
    if (rotation > kMaxRotationError) return false;
  }
  return !update.speed_measured || arbiter_.judge(OdometrySource::kLidar);
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
  for (const OdometrySource rests : {OdometrySource::kWheels, OdometrySource::kSpeed}) {
    arbiter_.put_out(rests, now_);
  }
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

}  // namespace infuse::motion

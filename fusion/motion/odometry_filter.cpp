#include "fusion/motion/odometry_filter.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::motion {
namespace {

constexpr size_t kMaxPendingSamples = 512;  // maximum number of samples waiting for earlier ones
constexpr Duration kMaxPredictionStep{50'000'000};  // maximum duration of one prediction
constexpr Duration kMaxStampJump{2'000'000'000};  // maximum gap between stamps; a single larger one
                                                  // is rejected
constexpr Duration kMinSteeringInterval{100'000'000};  // the errors are correlated: more samples
                                                       // add no information

template <class Range>
bool any_finite(const Range& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace

OdometryFilter::OdometryFilter(const OdometryOptions& options,
                               const geometry::TrajectoryOptions& trajectory)
    : options_(options), state_(options), trajectory_(trajectory) {
  pending_.reserve(kMaxPendingSamples);
}

void OdometryFilter::set_pose(const Eigen::Isometry3d& T_odom_vehicle,
                              const geometry::Matrix6& covariance) {
  state_.set_pose(T_odom_vehicle, covariance);
  trajectory_.clear();
}

void OdometryFilter::add(const WheelOdometry& sample) {
  if (!any_finite(sample.wheel_speed) && !std::isfinite(sample.yaw_rate) &&
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

void OdometryFilter::add(const GnssFix& fix) { insert(fix.stamp - options_.gnss_delay, fix); }

void OdometryFilter::insert(Stamp stamp, const Sample& sample) {
  if (!pending_.empty() || now_ != Stamp::earliest()) {
    const auto jumps = [&](Stamp from) {
      return stamp - from > kMaxStampJump || from - stamp > kMaxStampJump;
    };
    if (jumps(newest_stamp_)) {
      // One outlier stamp is an error; two that agree are a pause or a clock step.
      const bool confirmed = jumped_stamp_ && !jumps(*jumped_stamp_);
      jumped_stamp_ = stamp;
      if (!confirmed) {
        ++invalid_samples_;
        return;
      }
      if (stamp < newest_stamp_) reset_clock();
    }
    jumped_stamp_.reset();
  }
  if (stamp < now_) {
    ++late_;
    return;
  }
  if (pending_.size() == kMaxPendingSamples) process_until(pending_.front().stamp);
  const auto at = std::upper_bound(
      pending_.begin(), pending_.end(), stamp,
      [](Stamp value, const PendingSample& pending) { return value < pending.stamp; });
  pending_.insert(at, PendingSample{stamp, sample});
  newest_stamp_ = std::max(newest_stamp_, stamp);
  process_until(newest_stamp_ - options_.reorder);
}

void OdometryFilter::reset_clock() {
  pending_.clear();
  trajectory_.clear();
  state_.reset_motion(to_seconds(options_.max_silence));
  now_ = newest_stamp_ = last_speed_stamp_ = last_rotation_stamp_ = last_steering_stamp_ =
      Stamp::earliest();
  at_rest_since_ = Stamp::latest();
}

void OdometryFilter::flush() { process_until(Stamp::latest()); }

void OdometryFilter::process_until(Stamp until) {
  size_t done = 0;
  while (done < pending_.size() && pending_[done].stamp <= until) process(pending_[done++]);
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(done));
}

void OdometryFilter::process(const PendingSample& pending) {
  if (now_ == Stamp::earliest()) now_ = pending.stamp;
  Duration ahead = pending.stamp - now_;
  if (ahead > options_.max_silence) {
    state_.reset_motion(to_seconds(ahead));
    last_speed_stamp_ = last_rotation_stamp_ = Stamp::earliest();
    at_rest_since_ = Stamp::latest();
  } else {
    for (; ahead > kMaxPredictionStep; ahead -= kMaxPredictionStep)
      state_.predict(to_seconds(kMaxPredictionStep));
    state_.predict(to_seconds(ahead));
  }
  now_ = pending.stamp;
  std::visit([this](const auto& sample) { update(sample); }, pending.sample);
  extend_trajectory();
}

void OdometryFilter::update(const WheelOdometry& sample) {
  detect_standstill(sample);
  if (any_finite(sample.wheel_speed)) {
    const int accepted = state_.update_wheels(sample);
    handle_gate_result(accepted >= 1, last_speed_stamp_, &OdometryState::reset_speed_covariance);
  }
  if (std::isfinite(sample.yaw_rate)) {
    handle_gate_result(state_.update_yaw_rate(sample.yaw_rate), last_rotation_stamp_,
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
  if (whole) {
    handle_gate_result(state_.update_gyro(sample), last_rotation_stamp_,
                       &OdometryState::reset_rotation_covariance);
  }
  if (any_finite(sample.linear_acceleration)) state_.update_gravity(sample);
}

void OdometryFilter::update(const GnssFix& fix) { state_.update_gnss(fix); }

void OdometryFilter::handle_gate_result(bool accepted, Stamp& last_accepted,
                                        void (OdometryState::*reset_covariance)()) {
  if (accepted) {
    last_accepted = now_;
    return;
  }
  ++outliers_;
  if (last_accepted != Stamp::earliest() && now_ - last_accepted > options_.max_silence) {
    (state_.*reset_covariance)();
  }
}

void OdometryFilter::detect_standstill(const WheelOdometry& sample) {
  if (!any_finite(sample.wheel_speed)) return;
  const bool at_rest =
      std::none_of(sample.wheel_speed.begin(), sample.wheel_speed.end(),
                   [&](double v) { return std::abs(v) > options_.standstill_speed; });
  if (!at_rest) {
    at_rest_since_ = Stamp::latest();
  } else {
    at_rest_since_ = std::min(at_rest_since_, now_);
    if (now_ - at_rest_since_ >= options_.standstill_after) state_.update_standstill();
  }
}

const char* OdometryFilter::reason() const {
  if (now_ == Stamp::earliest()) return "no sample received yet";
  const auto silent = [this](Stamp last) {
    return last == Stamp::earliest() || now_ - last > options_.max_silence;
  };
  if (silent(last_speed_stamp_)) return "no valid wheel speed";
  if (silent(last_rotation_stamp_)) return "no valid yaw rate";
  return "";
}

void OdometryFilter::extend_trajectory() {
  if (!usable()) return;
  if (!trajectory_.empty() &&
      now_ - trajectory_[trajectory_.size() - 1].stamp < options_.pose_interval) {
    return;
  }
  trajectory_.append({now_, state_.T_odom_vehicle(), state_.pose_covariance()});
}

OdometryReport OdometryFilter::report() const {
  OdometryReport report;
  report.wheel_scale = state_.parameter(OdometryState::kWheelScale);
  report.yaw_rate_bias = state_.parameter(OdometryState::kYawRateBias);
  for (size_t i = 0; i < 3; ++i) {
    report.gyro_bias[i] = state_.parameter(OdometryState::kGyroBias + static_cast<int>(i));
  }
  report.steering_zero = state_.parameter(OdometryState::kSteeringZero);
  report.speed = state_.speed();
  report.angular_velocity = state_.angular_velocity();
  report.standing =
      at_rest_since_ != Stamp::latest() && now_ - at_rest_since_ >= options_.standstill_after;
  report.late = late_;
  report.outliers = outliers_;
  report.invalid_samples = invalid_samples_;
  return report;
}

}  // namespace infuse::motion

#include "fusion/motion/odometry_filter.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::motion {
namespace {

constexpr size_t kWaiting = 512;                    // samples that wait for earlier ones, at most
constexpr Duration kLongestStep{50'000'000};        // of one prediction
constexpr Duration kLeap{2'000'000'000};            // between stamps: one alone is not believed
constexpr Duration kSteeringInterval{100'000'000};  // its errors last: more samples tell no more

template <class Range>
bool any_finite(const Range& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace

OdometryFilter::OdometryFilter(const OdometryOptions& options,
                               const geometry::TrajectoryOptions& trajectory)
    : options_(options), state_(options), trajectory_(trajectory) {
  waiting_.reserve(kWaiting);
}

void OdometryFilter::set_pose(const Eigen::Isometry3d& T_map_vehicle,
                              const geometry::Matrix6& covariance) {
  state_.set_pose(T_map_vehicle, covariance);
  trajectory_.clear();
}

void OdometryFilter::add(const WheelOdometry& sample) {
  if (!any_finite(sample.wheel_speed) && !std::isfinite(sample.yaw_rate) &&
      !std::isfinite(sample.steering_angle)) {
    ++senseless_;
    return;
  }
  insert(sample.stamp - options_.wheel_delay, sample);
}

void OdometryFilter::add(const ImuSample& sample) {
  if (!any_finite(sample.angular_velocity) && !any_finite(sample.linear_acceleration)) {
    ++senseless_;
    return;
  }
  insert(sample.stamp - options_.imu_delay, sample);
}

void OdometryFilter::add(const GpsFix& fix) { insert(fix.stamp - options_.gps_delay, fix); }

void OdometryFilter::insert(Stamp stamp, const Sample& sample) {
  if (!waiting_.empty() || now_ != Stamp::earliest()) {
    const auto leaps = [&](Stamp from) { return stamp - from > kLeap || from - stamp > kLeap; };
    if (leaps(newest_)) {
      // One stamp may be wrong; two that agree are a pause, or a clock that was set.
      const bool confirmed = leap_ && !leaps(*leap_);
      leap_ = stamp;
      if (!confirmed) {
        ++senseless_;
        return;
      }
      if (stamp < newest_) restart_clock();
    }
    leap_.reset();
  }
  if (stamp < now_) {
    ++late_;
    return;
  }
  if (waiting_.size() == kWaiting) work_off(waiting_.front().stamp);
  const auto at =
      std::upper_bound(waiting_.begin(), waiting_.end(), stamp,
                       [](Stamp value, const Waiting& waiting) { return value < waiting.stamp; });
  waiting_.insert(at, Waiting{stamp, sample});
  newest_ = std::max(newest_, stamp);
  work_off(newest_ - options_.reorder);
}

void OdometryFilter::restart_clock() {
  waiting_.clear();
  trajectory_.clear();
  state_.lose_motion(to_seconds(options_.max_silence));
  now_ = newest_ = last_speed_ = last_rotation_ = last_steering_ = Stamp::earliest();
  at_rest_since_ = Stamp::latest();
}

void OdometryFilter::flush() { work_off(Stamp::latest()); }

void OdometryFilter::work_off(Stamp until) {
  size_t done = 0;
  while (done < waiting_.size() && waiting_[done].stamp <= until) process(waiting_[done++]);
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(done));
}

void OdometryFilter::process(const Waiting& waiting) {
  if (now_ == Stamp::earliest()) now_ = waiting.stamp;
  Duration ahead = waiting.stamp - now_;
  if (ahead > options_.max_silence) {
    state_.lose_motion(to_seconds(ahead));
    last_speed_ = last_rotation_ = Stamp::earliest();
    at_rest_since_ = Stamp::latest();
  } else {
    for (; ahead > kLongestStep; ahead -= kLongestStep) state_.predict(to_seconds(kLongestStep));
    state_.predict(to_seconds(ahead));
  }
  now_ = waiting.stamp;
  std::visit([this](const auto& sample) { use(sample); }, waiting.sample);
  extend_trajectory();
}

void OdometryFilter::use(const WheelOdometry& sample) {
  watch_standstill(sample);
  if (any_finite(sample.wheel_speed)) {
    const int agreed = state_.update_wheels(sample);
    heed(agreed >= 1, last_speed_, &OdometryState::loosen_speed);
  }
  if (std::isfinite(sample.yaw_rate)) {
    heed(state_.update_yaw_rate(sample.yaw_rate), last_rotation_, &OdometryState::loosen_rotation);
  }
  if (std::isfinite(sample.steering_angle) && now_ - last_steering_ >= kSteeringInterval) {
    if (state_.update_steering(sample.steering_angle)) last_steering_ = now_;
  }
}

void OdometryFilter::use(const ImuSample& sample) {
  const bool whole =
      options_.planar ? std::isfinite(sample.angular_velocity[2])
                      : std::all_of(sample.angular_velocity.begin(), sample.angular_velocity.end(),
                                    [](double v) { return std::isfinite(v); });
  if (whole) {
    heed(state_.update_gyro(sample), last_rotation_, &OdometryState::loosen_rotation);
  }
  if (any_finite(sample.linear_acceleration)) state_.update_gravity(sample);
}

void OdometryFilter::use(const GpsFix& fix) { state_.update_gps(fix); }

void OdometryFilter::heed(bool agreed, Stamp& last_agreed, void (OdometryState::*loosen)()) {
  if (agreed) {
    last_agreed = now_;
    return;
  }
  ++contradicted_;
  if (last_agreed != Stamp::earliest() && now_ - last_agreed > options_.max_silence) {
    (state_.*loosen)();
  }
}

void OdometryFilter::watch_standstill(const WheelOdometry& sample) {
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
  if (now_ == Stamp::earliest()) return "no sample has come yet";
  const auto silent = [this](Stamp last) {
    return last == Stamp::earliest() || now_ - last > options_.max_silence;
  };
  if (silent(last_speed_)) return "no believable wheel speed";
  if (silent(last_rotation_)) return "no believable yaw rate";
  return "";
}

void OdometryFilter::extend_trajectory() {
  if (!usable()) return;
  if (!trajectory_.empty() &&
      now_ - trajectory_[trajectory_.size() - 1].stamp < options_.pose_interval) {
    return;
  }
  trajectory_.append({now_, state_.T_map_vehicle(), state_.pose_covariance()});
}

OdometryReport OdometryFilter::report() const {
  OdometryReport report;
  report.wheel_scale = state_.learned(OdometryState::kWheelScale);
  report.yaw_rate_bias = state_.learned(OdometryState::kYawBias);
  for (size_t i = 0; i < 3; ++i) {
    report.gyro_bias[i] = state_.learned(OdometryState::kGyroBias + static_cast<int>(i));
  }
  report.steering_zero = state_.learned(OdometryState::kSteeringZero);
  report.speed = state_.speed();
  report.angular_velocity = state_.angular_velocity();
  report.standing =
      at_rest_since_ != Stamp::latest() && now_ - at_rest_since_ >= options_.standstill_after;
  report.late = late_;
  report.contradicted = contradicted_;
  report.senseless = senseless_;
  return report;
}

}  // namespace infuse::motion

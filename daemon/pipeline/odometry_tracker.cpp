#include "daemon/pipeline/odometry_tracker.hpp"

#include <limits>

namespace infuse::daemon {

void OdometryTracker::add(const VehicleSample& sample) {
  if (const auto* wheels = std::get_if<WheelOdometry>(&sample)) {
    filter_.add(*wheels);
  } else if (const auto* imu = std::get_if<ImuSample>(&sample)) {
    filter_.add(*imu);
  } else if (const auto* fix = std::get_if<GnssFix>(&sample); fix != nullptr && use_gnss_speed_) {
    GnssFix speed = *fix;
    speed.course = std::numeric_limits<double>::quiet_NaN();
    filter_.add(speed);
  }
}

PoseReport OdometryTracker::pose_at(Stamp stamp) const {
  const geometry::PoseAt pose = trajectory().at(stamp);
  const motion::OdometryReport odometry = filter_.report();
  PoseReport report;
  report.stamp = stamp;
  report.frame = PoseFrame::kOdom;
  report.T_frame_vehicle = pose.T_odom_vehicle;
  report.covariance = pose.covariance;
  report.speed = odometry.speed;
  report.yaw_rate = odometry.angular_velocity.z();
  report.reason = pose.usable() ? reason_at(stamp) : pose.reason;
  return report;
}

// The filter's time is that of its samples: it cannot detect their absence.
const char* OdometryTracker::reason_at(Stamp now) const {
  if (!filter_.usable() || trajectory().empty()) return filter_.reason();
  const Stamp last = trajectory()[trajectory().size() - 1].stamp;
  return now - last > max_silence_ ? "vehicle sensors silent" : "";
}

OdometryStatus OdometryTracker::status(Stamp now) const {
  const motion::OdometryReport report = filter_.report();
  OdometryStatus status;
  status.reason = reason_at(now);
  status.speed = report.speed;
  status.yaw_rate = report.angular_velocity.z();
  status.standing = report.standing;
  status.wheel_scale = report.wheel_scale.value;
  status.wheel_scale_sigma = report.wheel_scale.sigma;
  status.yaw_rate_bias = report.yaw_rate_bias.value;
  status.yaw_rate_bias_sigma = report.yaw_rate_bias.sigma;
  status.gyro_bias = report.gyro_bias[2].value;
  status.gyro_bias_sigma = report.gyro_bias[2].sigma;
  status.late = report.late;
  status.outliers = report.outliers;
  status.invalid_samples = report.invalid_samples;
  return status;
}

}  // namespace infuse::daemon

#include "daemon/pipeline/odometry_tracker.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/motion/wheel_speeds.hpp"

namespace infuse::daemon {
namespace {

motion::OdometryOptions filter_options(const OdometrySettings& settings) {
  constexpr double kUnknownHeading = 10;  // rad
  motion::OdometryOptions options = settings.filter;
  options.planar = settings.planar.value_or(!settings.use_lidar.value_or(false));
  options.east_heading_sigma = kUnknownHeading;
  return options;
}

/// The source that would bound what grows fastest: over a minute the heading by the bias of what
/// measures the rotation, the way by the scale of the wheels. Nothing where both stay within 1 %.
const char* wanted_source(const motion::OdometryReport& report) {
  constexpr double kMinute = 60, kSmall = 0.01;  // s, part of the way
  const auto carries = [&](motion::OdometrySource source) {
    return report.carries[static_cast<size_t>(source)];
  };
  if (carries(motion::OdometrySource::kLidar) || carries(motion::OdometrySource::kGnssCourse))
    return "";
  const bool gyro = carries(motion::OdometrySource::kGyro);
  const double bias = gyro ? report.gyro_bias[2].sigma : report.yaw_rate_bias.sigma;
  const double across = 0.5 * kMinute * bias;  // the heading errs by half of it on average
  const double along =
      carries(motion::OdometrySource::kWheels) || carries(motion::OdometrySource::kSpeed)
          ? report.wheel_scale.sigma
          : 0;
  if (std::max(across, along) < kSmall) return "";
  return across > along
             ? "the lidar (use_lidar), a steering angle, or the course of a GNSS receiver"
             : "the lidar (use_lidar), or the speed of a GNSS receiver";
}

}  // namespace

OdometryTracker::OdometryTracker(const OdometrySettings& settings,
                                 const Eigen::Isometry3d& T_vehicle_lidar)
    : filter_(filter_options(settings)),
      uses_lidar_(settings.use_lidar.value_or(false)),
      standstill_speed_(settings.filter.standstill_speed),
      gyro_axes_(T_vehicle_lidar.linear()),
      use_gnss_speed_(settings.use_gnss_speed),
      max_heading_sigma_(settings.max_heading_sigma),
      max_silence_(settings.filter.max_silence),
      max_gnss_silence_(settings.filter.max_gnss_silence) {}

void OdometryTracker::add(const VehicleSample& sample) {
  if (const auto* wheels = std::get_if<WheelOdometry>(&sample)) {
    see_rest(*wheels);
    filter_.add(*wheels);
  } else if (const auto* imu = std::get_if<ImuSample>(&sample)) {
    has_inertial_unit_ = true;
    filter_.add(*imu);
  } else if (const auto* fix = std::get_if<GnssFix>(&sample); fix != nullptr && use_gnss_speed_) {
    filter_.add(*fix);
  } else if (const auto* readings = std::get_if<GyroReadings>(&sample)) {
    add_gyros(*readings);
  }
}

void OdometryTracker::see_rest(const WheelOdometry& sample) {
  if (motion::measured_speeds(sample) == 0) return;
  wheels_rest_ = motion::is_at_rest(sample, standstill_speed_);
}

// An inertial unit of the vehicle is better, and the filter has the biases of one unit only.
void OdometryTracker::add_gyros(const GyroReadings& readings) {
  if (has_inertial_unit_) return;
  gyro_axes_.add(readings);
  if (const auto sample = gyro_axes_.measure(readings)) filter_.add(*sample);
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

void OdometryTracker::bound(PoseReport& pose) const {
  if (pose.usable() && pose.covariance(2, 2) > max_heading_sigma_ * max_heading_sigma_)
    pose.reason = "its heading is less sure than max_heading_sigma_deg";
}

// The filter's time is that of its samples: it cannot detect their absence.
const char* OdometryTracker::reason_at(Stamp now) const {
  if (!filter_.usable() || trajectory().empty()) return filter_.reason();
  const Stamp last = trajectory()[trajectory().size() - 1].stamp;
  const motion::OdometryReport report = filter_.report();
  const bool by_gnss = report.carries[static_cast<size_t>(motion::OdometrySource::kGnssSpeed)];
  return now - last > (by_gnss ? max_gnss_silence_ : max_silence_) ? "vehicle sensors silent" : "";
}

OdometryStatus OdometryTracker::status(Stamp now) const {
  const motion::OdometryReport report = filter_.report();
  OdometryStatus status;
  status.present = true;
  status.reason = reason_at(now);
  for (size_t i = 0; i < status.sources.size(); ++i) {
    status.sources[i] = {motion::kOdometrySourceNames[i], report.carries[i] && status.usable(),
                         report.sources[i].accepted, report.sources[i].rejected};
  }
  status.speed_sigma = report.speed_sigma;
  status.yaw_rate_sigma = report.yaw_rate_sigma;
  status.speed = report.speed;
  status.yaw_rate = report.angular_velocity.z();
  status.standing = report.standing;
  status.wheel_scale = report.wheel_scale.value;
  status.wheel_scale_sigma = report.wheel_scale.sigma;
  status.yaw_rate_bias = report.yaw_rate_bias.value;
  status.yaw_rate_bias_sigma = report.yaw_rate_bias.sigma;
  status.gyro_bias = report.gyro_bias[2].value;
  status.gyro_bias_sigma = report.gyro_bias[2].sigma;
  const auto set_delay = [&](motion::OdometrySource source, const motion::EstimatedParameter& from,
                             double& delay, double& sigma) {
    if (report.sources[static_cast<size_t>(source)].accepted == 0) return;
    delay = from.value;
    sigma = from.sigma;
  };
  set_delay(motion::OdometrySource::kYawRate, report.yaw_rate_delay, status.yaw_rate_delay,
            status.yaw_rate_delay_sigma);
  set_delay(motion::OdometrySource::kGyro, report.imu_delay, status.imu_delay,
            status.imu_delay_sigma);
  set_delay(motion::OdometrySource::kGnssSpeed, report.gnss_delay, status.gnss_delay,
            status.gnss_delay_sigma);
  status.steering_ratio = 1 / report.steering_gain.value;
  status.wanted = wanted_source(report);
  status.late = report.late;
  status.outliers = report.outliers;
  status.invalid_samples = report.invalid_samples;
  return status;
}

}  // namespace infuse::daemon

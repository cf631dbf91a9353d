#include "drivers/import/bag_samples.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "drivers/gnss/gnss_csv.hpp"
#include "drivers/recording/imu_csv.hpp"
#include "drivers/recording/speed_csv.hpp"

namespace infuse::importers {
namespace {

constexpr double kBagNan = std::numeric_limits<double>::quiet_NaN();

std::array<double, 3> rotate(const Eigen::Matrix3d& rotation, const ros::Vector3& v) {
  const Eigen::Vector3d rotated = rotation * Eigen::Vector3d(v.x, v.y, v.z);
  return {rotated.x(), rotated.y(), rotated.z()};
}

bool is_finite(const std::array<double, 3>& v) { return std::isfinite(v[0] + v[1] + v[2]); }

}  // namespace

void BagSamples::add(const BagMessage& message, const std::string& topic) {
  bool sound = true;
  if (topic == summary_.selection.speed) {
    sound = add_speed(message);
  } else if (topic == summary_.selection.imu) {
    sound = add_imu(message);
  } else if (topic == summary_.selection.gnss) {
    sound = add_fix(message);
  } else if (topic == summary_.selection.velocity) {
    sound = add_velocity(message);
  }
  if (!sound) ++unreadable_;
}

bool BagSamples::add_twist(const ros::Header& header, const ros::Twist& twist, Stamp log_time) {
  WheelOdometry sample;
  sample.stamp = stamp_of(header, log_time);
  sample.speed = twist.linear.x;
  sample.yaw_rate = twist.angular.z;
  if (!std::isfinite(sample.speed) && !std::isfinite(sample.yaw_rate)) return false;
  speeds_.push_back(sample);
  return true;
}

bool BagSamples::add_speed(const BagMessage& message) {
  if (message.type == ros::Odometry::kName) {
    const auto odometry = ros::decode<ros::Odometry>(message.data, message.encoding);
    return odometry && add_twist(odometry->header, odometry->twist, message.log_time);
  }
  if (message.type == ros::TwistWithCovarianceStamped::kName) {
    auto twist = ros::decode<ros::TwistWithCovarianceStamped>(message.data, message.encoding);
    if (!twist) return false;
    // A variance of -1: not measured.
    if (twist->covariance.front() == -1) twist->twist.linear.x = kBagNan;
    if (twist->covariance.back() == -1) twist->twist.angular.z = kBagNan;
    return add_twist(twist->header, twist->twist, message.log_time);
  }
  const auto twist = ros::decode<ros::TwistStamped>(message.data, message.encoding);
  return twist && add_twist(twist->header, twist->twist, message.log_time);
}

bool BagSamples::add_imu(const BagMessage& message) {
  const auto imu = ros::decode<ros::Imu>(message.data, message.encoding);
  // A covariance that begins with -1: not measured.
  if (!imu || imu->angular_velocity_covariance[0] == -1 ||
      imu->linear_acceleration_covariance[0] == -1) {
    return false;
  }
  const ImuSample sample{stamp_of(imu->header, message.log_time),
                         rotate(R_vehicle_imu_, imu->angular_velocity),
                         rotate(R_vehicle_imu_, imu->linear_acceleration)};
  if (!is_finite(sample.angular_velocity) || !is_finite(sample.linear_acceleration)) return false;
  imu_.push_back(sample);
  return true;
}

bool BagSamples::add_fix(const BagMessage& message) {
  constexpr double kRadians = std::numbers::pi / 180;
  const auto fix = ros::decode<ros::NavSatFix>(message.data, message.encoding);
  if (!fix || !(std::abs(fix->latitude) <= 90) || !(std::abs(fix->longitude) <= 360)) return false;
  fixes_.push_back({.stamp = stamp_of(fix->header, message.log_time),
                    .latitude = fix->latitude * kRadians,
                    .longitude = fix->longitude * kRadians,
                    .altitude = fix->altitude,
                    .speed = kBagNan,
                    .course = kBagNan,
                    .hdop = kBagNan,
                    .valid = fix->status >= 0});
  return true;
}

bool BagSamples::add_velocity(const BagMessage& message) {
  if (message.type == ros::TwistStamped::kName) {
    const auto twist = ros::decode<ros::TwistStamped>(message.data, message.encoding);
    return twist && add_over_ground(twist->header, twist->twist, message.log_time);
  }
  const auto twist = ros::decode<ros::TwistWithCovarianceStamped>(message.data, message.encoding);
  return twist && add_over_ground(twist->header, twist->twist, message.log_time);
}

bool BagSamples::add_over_ground(const ros::Header& header, const ros::Twist& twist,
                                 Stamp log_time) {
  const double east = twist.linear.x, north = twist.linear.y;
  if (!std::isfinite(east + north)) return false;
  velocities_.push_back({stamp_of(header, log_time), east, north});
  return true;
}

void BagSamples::join_velocities() {
  constexpr Duration kMaxGap{50'000'000};
  std::ranges::stable_sort(velocities_, {}, &Velocity::stamp);
  size_t without = 0;
  for (GnssFix& fix : fixes_) {
    auto nearest = std::ranges::lower_bound(velocities_, fix.stamp, {}, &Velocity::stamp);
    if (nearest != velocities_.begin() &&
        (nearest == velocities_.end() ||
         fix.stamp - std::prev(nearest)->stamp < nearest->stamp - fix.stamp))
      --nearest;
    if (nearest == velocities_.end() || distance_between(nearest->stamp, fix.stamp) > kMaxGap) {
      if (fix.valid) ++without;
      continue;
    }
    const double course = std::atan2(nearest->east, nearest->north);
    fix.speed = std::hypot(nearest->east, nearest->north);
    if (fix.speed > 0) fix.course = course < 0 ? course + 2 * std::numbers::pi : course;
  }
  if (without > 0 && !velocities_.empty()) {
    summary_.notes.push_back({std::to_string(without) + " fixes have no velocity within 50 ms",
                              summary_.selection.velocity, ""});
  }
}

Result<void> BagSamples::write(const std::filesystem::path& drive,
                               recording::DriveDescription& description) {
  const auto by_stamp = [](const auto& a, const auto& b) { return a.stamp < b.stamp; };
  std::stable_sort(speeds_.begin(), speeds_.end(), by_stamp);
  std::stable_sort(imu_.begin(), imu_.end(), by_stamp);
  std::stable_sort(fixes_.begin(), fixes_.end(), by_stamp);
  join_velocities();
  summary_.speeds = speeds_.size();
  summary_.imu_samples = imu_.size();
  summary_.fixes = fixes_.size();
  if (!speeds_.empty()) {
    description.speed = "speed.csv";
    if (auto done = recording::write_speed_csv(drive / "speed.csv", speeds_, true); !done)
      return done;
  }
  if (!imu_.empty()) {
    description.imu = "imu.csv";
    if (auto done = recording::write_imu_csv(drive / "imu.csv", imu_); !done) return done;
  }
  if (!fixes_.empty()) {
    description.gnss = "gnss.csv";
    if (auto done = gnss::write_gnss_csv(drive / "gnss.csv", fixes_); !done) return done;
  }
  return {};
}

}  // namespace infuse::importers

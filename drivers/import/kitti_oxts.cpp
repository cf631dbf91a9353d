#include "drivers/import/kitti_oxts.hpp"

#include <cmath>
#include <limits>

#include "drivers/gnss/local_frame.hpp"
#include "drivers/import/kitti_exposures.hpp"
#include "drivers/import/kitti_files.hpp"
#include "drivers/measurement/angles.hpp"

namespace infuse::importers {
namespace {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

// Columns of an oxts file: 0–2 latitude, longitude (°), altitude; 3–5 roll, pitch, yaw (rad, east
// is 0); 6, 7 speed north, east; 8–10 velocity forward, left, up, of which the first two are
// parallel to the ground; 11–13 acceleration, 17–19 angular velocity in vehicle axes.
using Row = std::vector<double>;

Eigen::Quaterniond yaw_of(const Row& row) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(row[5], Eigen::Vector3d::UnitZ()));
}

Eigen::Quaterniond attitude_of(const Row& row) {
  return yaw_of(row) * Eigen::AngleAxisd(row[4], Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(row[3], Eigen::Vector3d::UnitX());
}

// Of the inertial unit, in the axes of the map.
Eigen::Vector3d velocity_of(const Row& row) {
  return yaw_of(row) * Eigen::Vector3d(row[8], row[9], row[10]);
}

GnssFix fix_of(const Row& row, Stamp stamp) {
  GnssFix fix;
  fix.stamp = stamp;
  fix.latitude = row[0] * kDegree;
  fix.longitude = row[1] * kDegree;
  fix.altitude = row[2];
  fix.speed = std::hypot(row[6], row[7]);
  fix.course = std::atan2(row[7], row[6]);
  fix.hdop = kNotMeasured;
  fix.valid = true;
  return fix;
}

WheelOdometry speed_of(const Row& row, Stamp stamp, const Eigen::Isometry3d& T_imu_vehicle) {
  const Eigen::Vector3d rate(row[17], row[18], row[19]);
  const Eigen::Vector3d velocity = attitude_of(row).conjugate() * velocity_of(row);
  WheelOdometry sample;
  sample.stamp = stamp;
  sample.wheel_speed.fill(kNotMeasured);
  sample.yaw_rate = sample.steering_angle = kNotMeasured;
  sample.speed = (velocity + rate.cross(T_imu_vehicle.translation())).x();
  return sample;
}

}  // namespace

Result<KittiOxts> read_kitti_oxts(const std::filesystem::path& folder,
                                  const Eigen::Isometry3d& T_imu_vehicle,
                                  const std::vector<std::optional<TurnTimes>>& turns,
                                  std::vector<Error>& notes) {
  const auto times = read_kitti_times(folder / "timestamps.txt");
  if (!times) return tl::unexpected(times.error());
  const std::vector<StampedFile> files =
      assign_times(list_files(folder / "data", ".txt"), *times, notes);
  if (auto same = check_same_clock((folder / "timestamps.txt").string(), turns, files); !same)
    return tl::unexpected(same.error());
  KittiOxts result;
  std::optional<gnss::LocalFrame> map;
  Eigen::Vector3d position = Eigen::Vector3d::Zero(), last_velocity = Eigen::Vector3d::Zero();
  Stamp last = Stamp::earliest();
  size_t disordered = 0;
  for (const StampedFile& file : files) {
    const auto rows = read_number_lines(file.path, 30);
    if (!rows) return tl::unexpected(rows.error());
    if (rows->size() != 1) return fail("must contain one line", file.path.string());
    const Row& row = rows->front();
    const Stamp stamp = file.times.stamp;
    if (stamp <= last) {
      ++disordered;
      continue;
    }
    const Eigen::Vector3d velocity = velocity_of(row);
    if (!map) {
      map = gnss::make_local_frame(row[0] * kDegree, row[1] * kDegree, row[2]);
    } else {
      position += to_seconds(stamp - last) * 0.5 * (velocity + last_velocity);
    }
    last = stamp;
    last_velocity = velocity;
    const GnssFix fix = fix_of(row, stamp);
    const Eigen::Quaterniond attitude = attitude_of(row);
    const Eigen::Vector3d local = gnss::to_local(*map, fix.latitude, fix.longitude, fix.altitude);
    result.gnss.push_back(fix);
    result.speed.push_back(speed_of(row, stamp, T_imu_vehicle));
    result.imu.push_back({stamp, {row[17], row[18], row[19]}, {row[11], row[12], row[13]}});
    result.poses.push_back({stamp, Eigen::Translation3d(local) * attitude * T_imu_vehicle});
    result.path.push_back({stamp, Eigen::Translation3d(position) * attitude * T_imu_vehicle});
  }
  if (disordered > 0) {
    notes.push_back({std::to_string(disordered) + " stamps are not after the one before",
                     (folder / "timestamps.txt").string(), "these rows are skipped"});
  }
  return result;
}

}  // namespace infuse::importers

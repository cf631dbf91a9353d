#include "tests/study/places/true_map.hpp"

#include <algorithm>
#include <cmath>

#include "daemon/mapping/place_map.hpp"
#include "daemon/playback/play_lidar.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "daemon/tools/map/lidar_replay.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "fusion/features/air_returns.hpp"

namespace infuse::study {
namespace {

using geometry::StampedPose;

Result<std::vector<StampedPose>> read_poses(const std::string& file) {
  const auto poses = recording::read_trajectory(file);
  if (!poses) return tl::unexpected(poses.error());
  std::vector<StampedPose> out;
  for (const auto& pose : *poses) out.push_back({pose.stamp, pose.T_frame_body});
  return out;
}

}  // namespace

double TrueMap::error(const Eigen::Isometry3d& T_map_vehicle,
                      const Eigen::Isometry3d& truth) const {
  const auto distance = [&](const motion::PosePair& keyframe) {
    return (keyframe.estimate.translation() - T_map_vehicle.translation()).norm();
  };
  const motion::PosePair& nearest =
      *std::min_element(keyframes.begin(), keyframes.end(),
                        [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  return ((nearest.truth.inverse() * truth).translation() -
          (nearest.estimate.inverse() * T_map_vehicle).translation())
      .head<2>()
      .norm();
}

bool TrueMap::covers(const Eigen::Vector3d& truth) const {
  const double max_distance = places::PlaceMatcherOptions().max_distance;
  return std::any_of(keyframes.begin(), keyframes.end(), [&](const motion::PosePair& keyframe) {
    return (keyframe.truth.translation() - truth).head<2>().norm() < max_distance;
  });
}

Result<TrueMap> open_true_map(const std::string& map, const std::string& drive) {
  auto opened = daemon::open_place_map(daemon::MapFolder(map));
  if (!opened) return tl::unexpected(opened.error());
  const auto keyframes = read_poses(map + "/trajectory.tum");
  if (!keyframes) return tl::unexpected(keyframes.error());
  const auto truth = read_poses(drive + "/truth/poses.tum");
  if (!truth) return tl::unexpected(truth.error());
  return TrueMap{*std::move(opened), motion::pair_by_time(*keyframes, *truth)};
}

Result<LidarVisit> LidarVisit::open(const std::string& drive) {
  const auto setup = daemon::open_drive(drive, {}, {});
  if (!setup) return tl::unexpected(setup.error());
  auto truth = read_poses(drive + "/truth/poses.tum");
  if (!truth) return tl::unexpected(truth.error());
  LidarVisit visit;
  visit.drive_ = drive;
  visit.T_vehicle_lidar_ = setup->rig.lidars[0].T_vehicle_lidar;
  visit.truth_ = *std::move(truth);
  return visit;
}

const Eigen::Isometry3d& LidarVisit::true_pose(Stamp stamp) const {
  const auto distance = [&](const StampedPose& pose) {
    return std::abs(to_seconds(pose.stamp - stamp));
  };
  return std::min_element(truth_.begin(), truth_.end(),
                          [&](const auto& a, const auto& b) { return distance(a) < distance(b); })
      ->T_odom_vehicle;
}

std::string LidarVisit::play(const OnSweep& on_sweep) const {
  auto setup = daemon::open_drive(drive_, {}, {});
  if (!setup) return setup.error().message();
  daemon::LidarReplay odometry(*setup, 0);
  features::AirReturns air;
  daemon::play_lidar(
      *setup, 0, [&](const Sweep& sweep) { odometry.add_sweep(sweep); },
      [&](const daemon::VehicleSample& sample) { odometry.add_sample(sample); },
      [&](const recording::DriveEvent& event) {
        odometry.process_due(event.stamp, [&](const Sweep& sweep,
                                              const motion::DeskewedSweep& deskewed,
                                              const mapping::SweepMotion& motion) {
          air.find(sweep);
          on_sweep({air.without(deskewed.x), deskewed.y, deskewed.z}, sweep.reflectivity, motion);
        });
        return true;
      });
  return "";
}

}  // namespace infuse::study

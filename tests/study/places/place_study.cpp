#include "tests/study/places/place_study.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <memory>
#include <optional>
#include <ostream>

#include "daemon/commands/lidar_replay.hpp"
#include "daemon/commands/play_lidar.hpp"
#include "daemon/mapping/place_map.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "fusion/features/air_returns.hpp"
#include "fusion/motion/trajectory_error.hpp"

namespace infuse::study {
namespace {

using geometry::StampedPose;

std::optional<std::vector<StampedPose>> read_poses(const std::string& file) {
  const auto poses = recording::read_trajectory(file);
  if (!poses) return std::nullopt;
  std::vector<StampedPose> out;
  for (const auto& pose : *poses) out.push_back({pose.stamp, pose.T_frame_body});
  return out;
}

/// A map and where its keyframes truly were.
struct TrueMap {
  places::PlaceMap map;
  std::vector<motion::PosePair> keyframes;
};

/// Horizontal error, m, of a pose on the map relative to the nearest keyframe.
double error_on_map(const TrueMap& map, const Eigen::Isometry3d& T_map_vehicle,
                    const Eigen::Isometry3d& truth) {
  const auto distance = [&](const motion::PosePair& keyframe) {
    return (keyframe.estimate.translation() - T_map_vehicle.translation()).norm();
  };
  const motion::PosePair& nearest =
      *std::min_element(map.keyframes.begin(), map.keyframes.end(),
                        [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  return ((nearest.truth.inverse() * truth).translation() -
          (nearest.estimate.inverse() * T_map_vehicle).translation())
      .head<2>()
      .norm();
}

struct Start {
  places::Localiser localiser;
  Stamp stamp;
  double way = 0;
  double found_s = -1, found_m = -1;
  std::vector<StampedPose> tracked;
};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
}

}  // namespace

std::string study_places(std::ostream& out, const PlaceStudyOptions& options) {
  auto map = daemon::open_place_map(daemon::MapFolder(options.map));
  if (!map) return map.error().message();
  TrueMap true_map{*std::move(map), {}};
  const auto keyframes = read_poses(options.map + "/trajectory.tum");
  const auto map_truth = read_poses(options.map_drive + "/truth/poses.tum");
  if (!keyframes || !map_truth) return "the map or its truth cannot be read";
  true_map.keyframes = motion::pair_by_time(*keyframes, *map_truth);
  out << "drive | starts | found within 10 s | ever | wrong | s to the first, median | m | error, "
         "median, 95 %, max, m\n";
  for (const std::string& drive : options.drives) {
    auto setup = daemon::open_drive(drive, {}, {});
    if (!setup) return setup.error().message();
    const auto truth = read_poses(drive + "/truth/poses.tum");
    if (!truth) return drive + " has no truth";
    const Eigen::Isometry3d& T_vehicle_lidar = setup->rig.lidars[0].T_vehicle_lidar;
    std::vector<std::unique_ptr<Start>> starts, ended;
    double way = 0, next = 0;
    std::string error;
    daemon::LidarReplay odometry(*setup, 0);
    features::AirReturns air;
    const auto on_sweep = [&](const Sweep& sweep, const motion::DeskewedSweep& deskewed,
                              const mapping::SweepMotion& motion) {
      way += motion.T_from_to.translation().norm();
      if (motion.measured && way >= next) {
        next = way + options.spacing;
        starts.push_back(std::make_unique<Start>(Start{
            places::Localiser(true_map.map, T_vehicle_lidar), motion.stamp, way, -1, -1, {}}));
      }
      const auto x = air.without(sweep, deskewed.x);
      for (auto& start : starts) {
        const auto pose =
            start->localiser.add({x, deskewed.y, deskewed.z}, sweep.reflectivity, motion);
        if (!pose) {
          error = pose.error().message();
          return;
        }
        if (!pose->usable()) continue;
        if (start->found_s < 0) {
          start->found_s = to_seconds(motion.stamp - start->stamp);
          start->found_m = way - start->way;
        }
        start->tracked.push_back({motion.stamp, pose->T_map_vehicle});
      }
      const auto is_done = [&](const auto& start) {
        return way - start->way > options.max_way ||
               (start->found_m >= 0 && way - start->way > start->found_m + 20);
      };
      for (auto& start : starts) {
        if (is_done(start)) ended.push_back(std::move(start));
      }
      std::erase(starts, nullptr);
    };
    daemon::play_lidar(
        *setup, 0, [&](const Sweep& sweep) { odometry.add_sweep(sweep); },
        [&](const daemon::VehicleSample& sample) { odometry.add_sample(sample); },
        [&](const recording::DriveEvent& event) {
          odometry.process_due(event.stamp, on_sweep);
          return error.empty();
        });
    if (!error.empty()) return error;
    // A start whose drive ended before it was found or given up says nothing.
    size_t found = 0, soon = 0, wrong = 0;
    std::vector<double> seconds, metres, errors;
    for (const auto& start : ended) {
      if (start->found_s < 0) continue;
      ++found;
      soon += start->found_s <= 10 ? 1 : 0;
      seconds.push_back(start->found_s);
      metres.push_back(start->found_m);
      double worst = options.elsewhere ? INFINITY : 0;
      if (!options.elsewhere) {
        for (const motion::PosePair& pose : motion::pair_by_time(start->tracked, *truth)) {
          errors.push_back(error_on_map(true_map, pose.estimate, pose.truth));
          worst = std::max(worst, errors.back());
        }
      }
      wrong += worst > 1 ? 1 : 0;
    }
    out << std::fixed << std::setprecision(2) << drive << " | " << ended.size() << " | " << soon
        << " | " << found << " | " << wrong << " | " << quantile(seconds, 0.5) << " | "
        << quantile(metres, 0.5) << " | " << quantile(errors, 0.5) << ", " << quantile(errors, 0.95)
        << ", " << quantile(errors, 1) << std::endl;
  }
  return "";
}

}  // namespace infuse::study

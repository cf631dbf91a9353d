#pragma once

#include <functional>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "fusion/mapping/keyframes.hpp"
#include "fusion/motion/trajectory_error.hpp"
#include "fusion/places/place_matcher.hpp"

namespace infuse::study {

/// A map and simulated drives through its world, or past it.
struct VisitOptions {
  std::string map;                  ///< map folder
  std::string map_drive;            ///< the simulated drive that it was made of
  std::vector<std::string> drives;  ///< simulated visits, in the frame of that drive
};

/// A map and where its keyframes truly were.
struct TrueMap {
  places::PlaceMap map;
  std::vector<motion::PosePair> keyframes;

  /// Horizontal error, m, of a pose on the map relative to the nearest keyframe.
  double error(const Eigen::Isometry3d& T_map_vehicle, const Eigen::Isometry3d& truth) const;
  /// Whether a true position lies on the map: as near to a keyframe as the localiser looks.
  bool covers(const Eigen::Vector3d& truth) const;
};

/// Opens a map folder and the truth of the simulated drive that it was made of.
Result<TrueMap> open_true_map(const std::string& map, const std::string& drive);

/// A simulated drive with lidar, as `infuse map locate` reads it.
class LidarVisit {
 public:
  /// A deskewed sweep without what the air returns (lidar frame, m).
  using OnSweep =
      std::function<void(const geometry::PointsView& points, std::span<const float> reflectivity,
                         const mapping::SweepMotion& motion)>;

  static Result<LidarVisit> open(const std::string& drive);

  const Eigen::Isometry3d& T_vehicle_lidar() const { return T_vehicle_lidar_; }
  const std::vector<geometry::StampedPose>& truth() const { return truth_; }
  /// The true pose nearest in time.
  const Eigen::Isometry3d& true_pose(Stamp stamp) const;

  /// Reads the drive to its end; returns an error text, or nothing.
  std::string play(const OnSweep& on_sweep) const;

 private:
  std::string drive_;
  Eigen::Isometry3d T_vehicle_lidar_ = Eigen::Isometry3d::Identity();
  std::vector<geometry::StampedPose> truth_;
};

}  // namespace infuse::study

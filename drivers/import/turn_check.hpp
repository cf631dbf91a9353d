#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "drivers/import/import_files.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "drivers/recording/turn.hpp"

namespace infuse::importers {

/// What the sweeps of a moving vehicle say about a stated turn of its lidar.
struct TurnCheck {
  enum class Verdict {
    kConfirmed,  ///< the returns are sharpest with the times that follow from the turn
    kBlurs,      ///< they are sharper without times, or with another direction or cut
    kUnknown,    ///< the vehicle hardly moves, or its motion is not known
  };
  Verdict verdict = Verdict::kUnknown;
  std::string reason;  ///< statement for the user, with the numbers
};

/// Accumulates up to 25 consecutive sweeps, those with the longest path, along the vehicle's
/// trajectory, and counts the voxels of 10 cm that they occupy: deskewed with `turn`, not deskewed,
/// and deskewed with the other direction with one cut for all rings, and with the cut a quarter,
/// half and three quarters of a turn further. The right times give the fewest, by 0.5 % at least.
/// While the speed and the turn rate are constant, a wrong cut shifts whole sides of the street but
/// blurs nothing: `turn` is refused only if it gains less than half of what the best alternative
/// does.
TurnCheck check_turn(const recording::Turn& turn, const std::vector<StampedFile>& sweeps,
                     const std::vector<recording::TrajectoryPose>& path,
                     const Eigen::Isometry3d& T_vehicle_lidar);

}  // namespace infuse::importers

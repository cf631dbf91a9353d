#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"
#include "fusion/target/board.hpp"
#include "fusion/target/calibrate_target.hpp"

namespace infuse::daemon {

/// How views of boards are taken from a drive.
struct TargetViewOptions {
  target::BoardReturnsOptions returns;
  double corner_noise = 0.1;  ///< px an axis, one standard deviation
  int max_boards = 8;         ///< in one picture
  double min_motion = 0.02;   ///< m, rad; a board that has not moved farther is no new view

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// What was found in one or several drives of one rig.
struct TargetViews {
  std::vector<target::BoardObservation> observations;
  std::vector<std::string> names;    ///< "DRIVE front/000003 board 1", an entry a sighting
  std::vector<std::string> skipped;  ///< pictures and boards that gave none, and why
  std::string camera;                ///< its name
  Rig rig;                           ///< of the first drive
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();  ///< as that drive states it
  std::optional<Eigen::Isometry3d> truth;                            ///< the same, where known
};

/// Adds the views of one drive: in every picture of the camera the boards, in the lidar's sweep
/// nearest in time their returns. The vehicle and the boards should stand still meanwhile. Errors:
/// the drive cannot be read, there is no such camera.
Result<void> add_target_views(const std::filesystem::path& drive, const std::string& camera,
                              const target::Board& board, const TargetViewOptions& options,
                              TargetViews& views);

}  // namespace infuse::daemon

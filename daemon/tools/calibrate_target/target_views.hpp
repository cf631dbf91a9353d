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

/// Options of extracting views of boards from a drive.
struct TargetViewOptions {
  target::BoardReturnsOptions returns;
  double corner_noise = 0.1;  ///< standard deviation per axis, px
  int max_boards = 8;         ///< maximum number of boards in one image
  double min_motion = 0.02;   ///< m and rad; a board that has moved less gives no new view

  /// Returns what is wrong with the options, or nothing.
  std::optional<std::string> invalid() const;
};

/// Views of boards from one or several drives of one rig.
struct TargetViews {
  std::vector<target::BoardObservation> observations;
  std::vector<std::string> names;    ///< "DRIVE/front/000003 board 1", one per observation
  std::vector<std::string> skipped;  ///< images and boards without a view, and why
  std::string camera;                ///< name of the camera
  Rig rig;                           ///< of the first drive
  Eigen::Isometry3d T_camera_lidar =
      Eigen::Isometry3d::Identity();       ///< as stated by the first drive
  std::optional<Eigen::Isometry3d> truth;  ///< ground truth, if known
};

/// Adds the views of one drive: the boards in every image of the camera, with their returns in the
/// lidar's sweep nearest in time. The vehicle and the boards should stand still. Errors: the drive
/// cannot be read, no such camera.
Result<void> add_target_views(const std::filesystem::path& drive, const std::string& camera,
                              const target::Board& board, const TargetViewOptions& options,
                              TargetViews& views);

}  // namespace infuse::daemon

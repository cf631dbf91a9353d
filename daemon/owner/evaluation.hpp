#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/protocol/json.hpp"
#include "drivers/measurement/error.hpp"
#include "fusion/geometry/extrinsic_error.hpp"
#include "fusion/motion/trajectory_error.hpp"

namespace infuse::daemon {

/// Errors of a trajectory relative to the ground truth.
struct TrajectoryScore {
  size_t poses = 0;  ///< number of poses of the result
  size_t truth_poses = 0;
  size_t paired = 0;     ///< poses with a true pose at their time
  bool by_line = false;  ///< a file has no times (KITTI): paired line by line
  motion::Alignment alignment = motion::Alignment::kRigid;
  motion::AbsoluteError absolute;
  Duration span{1'000'000'000};  ///< time span of `relative`
  motion::RelativeError relative;
  motion::KittiError kitti;
};

/// Scores a TUM or KITTI file against another one, or against a drive's true poses.
Result<TrajectoryScore> score_trajectory(const std::filesystem::path& result,
                                         const std::filesystem::path& truth,
                                         motion::Alignment alignment, Duration span);

/// Error of one camera's extrinsics relative to the ground truth.
struct CameraScore {
  std::string camera;
  geometry::ExtrinsicError error;
};

/// Scores the cameras that the result (a rig.toml, a drive, or the JSON of a calibration) and the
/// truth (a rig.toml, or a drive with a true rig) have in common.
Result<std::vector<CameraScore>> score_rig(const std::filesystem::path& result,
                                           const std::filesystem::path& truth);

Json to_json(const TrajectoryScore& score);
Json to_json(const std::vector<CameraScore>& scores);
std::string to_text(const TrajectoryScore& score);
std::string to_text(const std::vector<CameraScore>& scores);

}  // namespace infuse::daemon

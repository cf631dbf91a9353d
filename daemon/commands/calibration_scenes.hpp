#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::daemon {

/// Which pairs of a sweep and a picture are taken from drives.
struct SceneRequest {
  std::vector<std::string> drives;
  std::vector<std::string> cameras;  ///< names, the head first; empty: the only one
  std::string lidar;                 ///< name; empty: the one that the head's extrinsics refer to
  int max_scenes =
      20;  ///< of each camera at most, all drives together, spread evenly over their time
  Duration max_gap{75'000'000};  ///< between the exposure and the middle of the sweep
};

/// A picture and the sweep nearest to its exposure.
struct ScenePair {
  std::string name;   ///< drive and number of the picture; of several cameras also the camera's
  size_t camera = 0;  ///< which of ScenePairs::cameras took the picture
  Stamp stamp;        ///< of the exposure
  Duration gap{0};    ///< to the middle of the sweep
  CameraFrame frame;
  Sweep sweep;                ///< as of the exposure, where `uncompensated` is empty
  std::string deskew_reason;  ///< why the sweep is as it was measured; empty where it is straight
  std::optional<geometry::Vector6> twist;  ///< PairedSweep::twist
};

/// What the drives hold for a calibration.
struct ScenePairs {
  /// As the first drive states them; the first is the head. What the rig says of them relative to
  /// each other is taken for known (P 3.4.1).
  std::vector<CameraMount> cameras;
  std::string lidar;
  Rig rig;                                 ///< of the first drive
  std::optional<Eigen::Isometry3d> truth;  ///< T_refcam_lidar, where the first drive has a true rig
  std::vector<ScenePair> pairs;
  std::vector<std::string> notes;  ///< what was left out, and why
};

/// Where a camera stands relative to the head, as the rig says.
Eigen::Isometry3d T_camera_refcam(const ScenePairs& pairs, size_t camera);

/// "front", or "front, left and right" of several.
std::string camera_names(const ScenePairs& pairs);

/// Reads the pairs. Sweeps are corrected for the vehicle's motion to the picture's exposure where
/// odometry says what it was. Errors: a drive that cannot be read, a sensor that is not there,
/// drives whose cameras differ. `progress` is told the share that has been read.
Result<ScenePairs> read_scene_pairs(const SceneRequest& request,
                                    const std::function<void(double)>& progress);

}  // namespace infuse::daemon

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
  std::string camera;            ///< name; empty: the only one
  std::string lidar;             ///< name; empty: the one that the camera's extrinsics refer to
  int scenes = 20;               ///< at most, all drives together, spread evenly over their time
  Duration max_gap{75'000'000};  ///< between the exposure and the middle of the sweep
};

/// A picture and the sweep nearest to its exposure.
struct ScenePair {
  std::string name;  ///< drive and number of the picture
  Stamp stamp;       ///< of the exposure
  Duration gap{0};   ///< to the middle of the sweep
  CameraFrame frame;
  Sweep sweep;                ///< as of the exposure, where `uncompensated` is empty
  std::string uncompensated;  ///< why the sweep is as it was measured; empty where it is straight
  std::optional<geometry::Vector6> twist;  ///< PairedSweep::twist
};

/// What the drives hold for a calibration.
struct ScenePairs {
  CameraMount camera;  ///< as the first drive states it
  std::string lidar;
  Rig rig;                                 ///< of the first drive
  std::optional<Eigen::Isometry3d> truth;  ///< T_camera_lidar, where the first drive has a true rig
  std::vector<ScenePair> pairs;
  std::vector<std::string> notes;  ///< what was left out, and why
};

/// Reads the pairs. Sweeps are corrected for the vehicle's motion to the picture's exposure where
/// odometry says what it was. Errors: a drive that cannot be read, a sensor that is not there,
/// drives whose cameras differ. `progress` is told the share that has been read.
Result<ScenePairs> read_scene_pairs(const SceneRequest& request,
                                    const std::function<void(double)>& progress);

}  // namespace infuse::daemon

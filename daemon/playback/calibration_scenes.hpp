#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/pipeline/pairing.hpp"
#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/calibration/scene.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::daemon {

/// Which pairs of a sweep and an image are read from drives.
struct SceneRequest {
  std::vector<std::string> drives;
  std::vector<std::string> cameras;  ///< names, the reference camera first; empty: the only camera
  std::string lidar;    ///< name; empty: the lidar that the reference camera's extrinsics refer to
  int max_scenes = 20;  ///< maximum number of images of each camera, over all drives together,
                        ///< spread evenly over their time
  Duration max_gap = kMaxPairingGap;  ///< from the exposure to the span of the sweep
};

/// An image and the sweep nearest to its exposure.
struct ScenePair {
  std::string name;  ///< drive and number of the image; with several cameras also the camera's name
  size_t camera = 0;          ///< index in ScenePairs::cameras
  Stamp stamp;                ///< of the exposure
  Duration gap{0};            ///< to the span of the sweep
  CameraFrame frame;          ///< empty once it is released
  Sweep sweep;                ///< the same; deskewed to the exposure if `deskew_reason` is empty
  std::string deskew_reason;  ///< why the sweep is not deskewed; empty if it is
  Duration uncompensated{0};  ///< PairedSweep::uncompensated
  std::optional<geometry::Vector6> twist;  ///< PairedSweep::twist
  std::vector<calibration::Scene> scenes;  ///< made by a `PairConsumer`, if one makes them

  bool has_data() const { return !frame.pixels.empty(); }

  /// Frees the image and the sweep.
  void release() {
    frame = {};
    sweep = {};
  }
};

/// The data for a calibration.
struct ScenePairs {
  /// As stated by the first drive; the first is the reference camera. Their poses relative to each
  /// other are taken from the rig as known (P 3.4.1).
  std::vector<CameraMount> cameras;
  std::string lidar;
  Rig rig;                                 ///< of the first drive
  std::optional<Eigen::Isometry3d> truth;  ///< T_refcam_lidar, if the first drive has a true rig
  std::vector<ScenePair> pairs;
  std::vector<std::string> notes;  ///< what was left out and why
};

/// Pose of a camera relative to the reference camera, as stated by the rig.
Eigen::Isometry3d T_camera_refcam(const ScenePairs& pairs, size_t camera);

/// Names of the cameras: "front", or "front, left and right".
std::string camera_names(const ScenePairs& pairs);

/// Receives every pair as soon as it is read, and may release its data and that of earlier ones:
/// then few pairs are in memory at a time. `pairs` has the cameras so far and the earlier pairs.
using PairConsumer = std::function<Result<void>(ScenePairs& pairs, ScenePair& pair)>;

/// Reads the pairs. Sweeps are deskewed to the image's exposure if odometry covers it. Errors: a
/// drive that cannot be read, a missing sensor, drives whose cameras differ, those of `consume`.
/// `progress` receives the fraction that has been read.
Result<ScenePairs> read_scene_pairs(const SceneRequest& request,
                                    const std::function<void(double)>& progress,
                                    const PairConsumer& consume = {});

}  // namespace infuse::daemon

#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::study {

/// An image and the sweep taken with it, deskewed to the exposure by the true motion.
struct RigScene {
  CameraFrame frame;
  Sweep sweep;
  geometry::Vector6 twist = geometry::Vector6::Zero();  ///< rad/s, m/s: of the lidar, in its frame
};

/// Scenes of a rig drawn at random, with its truth.
struct RigRecording {
  CameraIntrinsics camera;
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
  std::vector<RigScene> diverse;     ///< spread over a drive
  std::vector<RigScene> neighbours;  ///< of consecutive turns
  const char* lidar = "";            ///< model
};

/// Which scenes are rendered.
struct RigRecordingOptions {
  int diverse = 20;
  int neighbours = 8;
  double duration = 40;  ///< s, over which the diverse ones are spread
  /// Seed of the world, its light and the way; empty: that of the rig.
  std::optional<uint64_t> world;
};

/// Renders the scenes of the rig that `seed` draws (`simulator::draw_scenario`), in memory.
Result<RigRecording> record_random_rig(uint64_t seed, const RigRecordingOptions& options);

}  // namespace infuse::study

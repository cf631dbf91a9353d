#pragma once

#include <cstdint>
#include <vector>

#include "daemon/pipeline/picture_stage.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/rig.hpp"
#include "fusion/geometry/camera_model.hpp"
#include "fusion/motion/compensation.hpp"

namespace infuse::daemon {

/// One camera on the fusion thread: the returns of the sweep during which a picture was exposed, as
/// they were at that moment, projected into it.
class CameraStage {
 public:
  /// `mount.invalid()` must be empty; `T_vehicle_lidar` is that of the lidar it refers to.
  CameraStage(const CameraMount& mount, const Eigen::Isometry3d& T_vehicle_lidar);

  /// Makes the sweep straight as of the exposure, projects it, and says what came of it. `picture`
  /// is readable.
  FrameReport look(const Picture& picture, const Sweep& sweep,
                   const geometry::Trajectory& trajectory);

 private:
  uint32_t count_in_view();

  CameraMount mount_;
  geometry::CameraModel model_;
  motion::MotionCompensator compensator_;
  motion::StraightSweep straight_;
  Channel<float> u_, v_, depth_;
};

}  // namespace infuse::daemon

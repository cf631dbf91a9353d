#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/calibration/calibration_guard.hpp"
#include "daemon/pipeline/image_thread.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/rig.hpp"
#include "fusion/geometry/camera_model.hpp"
#include "fusion/motion/deskew.hpp"

namespace infuse::daemon {

/// One camera on the fusion thread: the returns of the sweep during which a picture was exposed, as
/// they were at that moment, projected into it.
class CameraChannel {
 public:
  /// `mount.invalid()` must be empty; `T_vehicle_lidar` is that of the lidar it refers to.
  /// `waits`: as a replay does for background work.
  CameraChannel(const CameraMount& mount, const Eigen::Isometry3d& T_vehicle_lidar,
                const CalibrationSettings& calibration, bool blocking);

  /// Makes the sweep straight as of the exposure, projects it, and says what came of it. `picture`
  /// is readable.
  FrameReport project(const CameraImage& image, const Sweep& sweep,
                      const geometry::Trajectory& trajectory);

  /// The sweep as of the last picture's exposure.
  const motion::DeskewedSweep& deskewed() const { return deskewed_; }

  /// Watches the calibration with the picture and the sweep that were looked at last. What is to be
  /// told of it, or null.
  const CalibrationReport* monitor(const CameraImage& image, const Sweep& sweep,
                                   const geometry::Trajectory& trajectory);

  /// What the owner asks of the calibration.
  void handle_request(const Request& request) {
    if (guard_) guard_->handle_request(request);
  }

  /// No re-estimation goes on or begins from now on; from any thread.
  void shut_down() {
    if (guard_) guard_->shut_down();
  }

  const std::string& name() const { return mount_.name; }

 private:
  uint32_t count_points_in_view();
  monitoring::Motion motion_at(Stamp exposure, const geometry::Trajectory& trajectory) const;

  CameraMount mount_;
  Eigen::Isometry3d T_vehicle_lidar_;
  geometry::CameraModel model_;
  motion::Deskewer deskewer_;
  motion::DeskewedSweep deskewed_;
  bool projected_ = false;  // the picture and the sweep that were looked at last
  CameraFrame grey_;
  std::optional<CalibrationGuard> guard_;
  FieldVector<float> u_, v_, depth_;
};

}  // namespace infuse::daemon

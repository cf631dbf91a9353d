#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "daemon/calibration/calibration_guard.hpp"
#include "daemon/pipeline/image_match.hpp"
#include "drivers/measurement/rig.hpp"
#include "fusion/geometry/camera_model.hpp"
#include "fusion/motion/deskew.hpp"

namespace infuse::daemon {

/// Processing of one camera on the fusion thread: projects sweeps into its images, and monitors its
/// calibration with them.
class CameraChannel {
 public:
  /// `mount.invalid()` must be empty; `lidar` is the one that the mount refers to. `blocking`:
  /// waits for background work (replay).
  CameraChannel(const CameraMount& mount, LidarIndex lidar,
                const Eigen::Isometry3d& T_vehicle_lidar, const CalibrationSettings& calibration,
                bool blocking);

  /// Deskews the sweep as of the exposure, of each row if the shutter is rolling, and projects it
  /// into the image, which is readable. The result is valid until the next call.
  ImageMatch project(const CameraImage& image, const Sweep& sweep,
                     const geometry::Trajectory& trajectory);

  /// Monitors the calibration with a usable match. Returns the report if one is due, else null.
  const CalibrationReport* monitor(const ImageMatch& match, const geometry::Trajectory& trajectory);

  /// Keeps the calibration valid; null if it is not monitored.
  CalibrationGuard* guard() { return guard_ ? &*guard_ : nullptr; }

  /// Stops re-estimation, and starts none from now on; from any thread.
  void shut_down() {
    if (guard_) guard_->shut_down();
  }

  /// T_camera_lidar of the last re-estimation; null before the first.
  const Eigen::Isometry3d* estimate() const { return guard_ ? guard_->estimate() : nullptr; }

  const std::string& name() const { return mount_.name; }
  /// Lidar that the calibration refers to.
  LidarIndex lidar() const { return lidar_; }

 private:
  const Eigen::Isometry3d& T_camera_lidar() const {
    return guard_ ? guard_->T_camera_lidar() : mount_.T_camera_lidar;
  }
  const char* mismatch(const CameraImage& image, const Sweep& sweep) const;
  uint32_t count_points_in_view(const motion::DeskewedSweep& deskewed);
  static std::optional<geometry::Vector6> twist_before(Stamp exposure,
                                                       const geometry::Trajectory& trajectory);
  void move_to_rows(Stamp exposure, const geometry::Trajectory& trajectory);
  monitoring::Motion motion_at(Stamp exposure, const geometry::Trajectory& trajectory) const;

  CameraMount mount_;
  LidarIndex lidar_;
  Eigen::Isometry3d T_vehicle_lidar_;
  geometry::CameraModel model_;
  motion::Deskewer deskewer_;
  std::optional<CalibrationGuard> guard_;
  // Memory that is used again:
  motion::DeskewedSweep deskewed_;
  CameraFrame grey_;
  FieldVector<float> u_, v_, depth_;
};

}  // namespace infuse::daemon

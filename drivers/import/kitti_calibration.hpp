#pragma once

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <optional>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::importers {

/// KITTI's published calibration of a rig.
struct KittiCalibration {
  /// Pᵢ = [K | p], from coordinates of rectified camera 0 to pixels of camera i; absent if not
  /// given.
  std::array<std::optional<Eigen::Matrix<double, 3, 4>>, 4> projection;
  Eigen::Isometry3d T_rectified_lidar =
      Eigen::Isometry3d::Identity();             ///< R0_rect · Tr_velo_to_cam
  std::optional<Eigen::Isometry3d> T_lidar_imu;  ///< Tr_imu_to_velo

  bool operator==(const KittiCalibration& other) const;

  /// Returns [I | K⁻¹·p] · R0_rect · Tr_velo_to_cam of a camera that has a projection.
  Eigen::Isometry3d T_camera_lidar(size_t camera) const;

  /// Returns pinhole intrinsics without distortion: KITTI's images are rectified.
  CameraIntrinsics intrinsics(size_t camera, int width, int height) const;

  /// Returns the pose of the lidar in the vehicle frame. The vehicle's axes are those of the
  /// inertial unit if known, otherwise those of the lidar; its origin is below the rear axle. The
  /// position is taken from KITTI's drawing of the car: the lidar is 1.73 m above the road and 0.76
  /// m in front of the rear axle, accurate to about 0.1 m.
  Eigen::Isometry3d T_vehicle_lidar() const;
};

/// Reads a calibration file of the object layout (calib/NNNNNN.txt: P0–P3, R0_rect, Tr_velo_to_cam,
/// Tr_imu_to_velo) or the odometry layout (calib.txt: P0–P3, Tr).
Result<KittiCalibration> read_kitti_calibration(const std::filesystem::path& file);

/// Reads the calibration of the raw layout: a folder with calib_cam_to_cam.txt,
/// calib_velo_to_cam.txt and, optionally, calib_imu_to_velo.txt.
Result<KittiCalibration> read_kitti_raw_calibration(const std::filesystem::path& folder);

}  // namespace infuse::importers

#pragma once

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <optional>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"

namespace infuse::recording {

/// KITTI's published calibration of one rig.
struct KittiCalibration {
  /// Pᵢ = [K | p]: rectified camera 0 coordinates to pixels of camera i; absent where not given.
  std::array<std::optional<Eigen::Matrix<double, 3, 4>>, 4> projection;
  Eigen::Isometry3d T_rectified_lidar =
      Eigen::Isometry3d::Identity();             ///< R0_rect · Tr_velo_to_cam
  std::optional<Eigen::Isometry3d> T_lidar_imu;  ///< Tr_imu_to_velo

  bool operator==(const KittiCalibration& other) const;

  /// [I | K⁻¹·p] · R0_rect · Tr_velo_to_cam of a camera that has a projection.
  Eigen::Isometry3d T_camera_lidar(size_t camera) const;

  /// Pinhole without distortion: KITTI's pictures are rectified.
  CameraIntrinsics intrinsics(size_t camera, int width, int height) const;

  /// The vehicle frame of design: x forward, z up along the inertial unit's axes where that is
  /// known (the lidar's otherwise), origin below the rear axle. Position after KITTI's published
  /// drawing of the car: lidar 1.73 m above the road, 0.76 m before the rear axle; good to about
  /// 0.1 m.
  Eigen::Isometry3d T_vehicle_lidar() const;
};

/// Object layout (calib/NNNNNN.txt: P0–P3, R0_rect, Tr_velo_to_cam, Tr_imu_to_velo) or odometry
/// layout (calib.txt: P0–P3, Tr).
Result<KittiCalibration> read_kitti_calibration(const std::filesystem::path& file);

/// Raw layout: a folder with calib_cam_to_cam.txt, calib_velo_to_cam.txt, calib_imu_to_velo.txt
/// (the last may be missing).
Result<KittiCalibration> read_kitti_raw_calibration(const std::filesystem::path& folder);

}  // namespace infuse::recording

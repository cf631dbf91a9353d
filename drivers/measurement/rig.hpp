#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// Intrinsics of a camera: the mapping from directions to pixels.
struct CameraIntrinsics {
  /// Kind of lens and its distortion.
  enum class Model {
    kPinhole,  ///< distortion (k1, k2, p1, p2, k3): Brown–Conrady, as OpenCV's calib3d
    kFisheye,  ///< distortion (k1, k2, k3, k4): Kannala–Brandt, as OpenCV's cv::fisheye
  };
  Model model = Model::kPinhole;  ///< kind of lens
  int width = 0;                  ///< pixels
  int height = 0;                 ///< pixels
  double fx = 0, fy = 0;          ///< focal lengths, pixels
  double cx = 0, cy = 0;  ///< principal point, pixels; the centre of the top left pixel is (0, 0)
  std::array<double, 5> distortion{};  ///< as `model` states

  /// Returns what is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;
};

/// Standard deviations of a camera's intrinsics.
struct IntrinsicsSigma {
  double focal_length = 0;     ///< of the logarithm of the focal lengths
  double principal_point = 0;  ///< px, across and down
  double radial = 0;           ///< of k1
};

/// Mounting of a camera.
struct CameraMount {
  std::string name;             ///< unique in the rig
  CameraIntrinsics intrinsics;  ///< of its images
  std::string lidar;            ///< name of the lidar that the extrinsics refer to
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();  ///< extrinsics
  Duration stamp_delay{0};        ///< stamp minus middle of the exposure; subtracted on reading
  Duration stamp_delay_sigma{0};  ///< standard deviation of the exposure's time
  /// From the exposure of the top row to that of the bottom row; "the exposure" is that of the
  /// middle row. 0: a global shutter. Negative: the bottom row is the first.
  Duration readout{0};
  /// To what the intrinsics are known; empty: nobody states it.
  std::optional<IntrinsicsSigma> intrinsics_sigma = std::nullopt;
};

/// Mounting of a lidar.
struct LidarMount {
  std::string name;   ///< unique in the rig
  std::string model;  ///< as drivers/velodyne names it ("HDL-32E"); empty for decoded sweeps
  Eigen::Isometry3d T_vehicle_lidar = Eigen::Isometry3d::Identity();  ///< mounting

  /// False if the vehicle frame is the lidar's own: then no axis of it need point forward.
  bool is_mounting_known() const { return T_vehicle_lidar.matrix() != Eigen::Matrix4d::Identity(); }
};

/// Sensors of a vehicle and their mounting. Names are unique within each list.
struct Rig {
  std::vector<LidarMount> lidars;    ///< may be empty
  std::vector<CameraMount> cameras;  ///< may be empty

  /// Returns what is wrong, or nothing: two sensors of one name, a camera that refers to no lidar,
  /// a transform that is not rigid.
  std::optional<std::string> invalid() const;

  /// Returns the lidar of that name, or null.
  const LidarMount* find_lidar(const std::string& name) const;
  const CameraMount* find_camera(const std::string& name) const;  ///< the camera
};

}  // namespace infuse

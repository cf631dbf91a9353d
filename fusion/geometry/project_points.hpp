#pragma once

#include <span>

#include "fusion/geometry/camera_model.hpp"

namespace infuse::geometry {

/// Points as a structure of arrays, m; all spans have the same length.
struct PointsView {
  std::span<const float> x, y, z;  ///< m
};

/// Pixels as a structure of arrays; all spans are as long as those of the points.
struct PixelsView {
  std::span<float> u, v;   ///< pixels; NaN where the camera model does not project the point
  std::span<float> depth;  ///< m along the optical axis, also where u and v are NaN
};

/// Projects many lidar points in single precision, within 0.01 pixel of `CameraModel` for images up
/// to 4096 pixels wide and points from 1 m. Includes pixels outside the image. Same bytes on every
/// processor.
void project_points(const CameraModel& camera, const Eigen::Isometry3d& T_camera_lidar,
                    const PointsView& points, const PixelsView& pixels);

}  // namespace infuse::geometry

#include "fusion/geometry/rolling_shutter.hpp"

#include <algorithm>

namespace infuse::geometry {

void RollingShutter::move(const Eigen::Isometry3d& T_camera_lidar, std::span<float> x,
                          std::span<float> y, std::span<float> z, const PixelsView& pixels) const {
  project_points(camera, T_camera_lidar, {x, y, z}, pixels);
  const auto last = static_cast<float>(std::max(camera.intrinsics().height - 1, 1));
  const auto span = static_cast<float>(to_seconds(readout));
  const Eigen::Vector3f w = twist.head<3>().cast<float>(), v = twist.tail<3>().cast<float>();
  for (size_t i = 0; i < x.size(); ++i) {
    const float row = pixels.v[i];
    // Points beside the image move with its first or last row; a NaN is no row.
    const float dt = row == row ? span * (std::clamp(row, 0.0F, last) / last - 0.5F) : 0.0F;
    const float dx = w.y() * z[i] - w.z() * y[i] + v.x();
    const float dy = w.z() * x[i] - w.x() * z[i] + v.y();
    const float dz = w.x() * y[i] - w.y() * x[i] + v.z();
    x[i] -= dt * dx;
    y[i] -= dt * dy;
    z[i] -= dt * dz;
  }
}

}  // namespace infuse::geometry

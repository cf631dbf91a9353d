#include "fusion/registration/visual/visible_returns.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/features/occlusion_buffer.hpp"
#include "fusion/geometry/plane_length.hpp"

namespace infuse::registration {

VisibleReturns::VisibleReturns(const geometry::PointsView& points, const CameraMount& camera)
    : width_(camera.intrinsics.width),
      height_(camera.intrinsics.height),
      u_(points.x.size()),
      v_(points.x.size()),
      returns_(static_cast<size_t>(width_) * static_cast<size_t>(height_), -1) {
  std::vector<float> depth(points.x.size());
  geometry::project_points(geometry::CameraModel(camera.intrinsics), camera.T_camera_lidar, points,
                           {u_, v_, depth});
  const auto in_image = [&](size_t i) {
    return depth[i] > 0 && u_[i] >= -0.5F && v_[i] >= -0.5F &&
           u_[i] < static_cast<float>(width_) - 0.5F && v_[i] < static_cast<float>(height_) - 0.5F;
  };
  features::OcclusionBuffer occlusion({});
  occlusion.reset(width_, height_);
  for (size_t i = 0; i < u_.size(); ++i) {
    if (in_image(i)) occlusion.add(u_[i], v_[i], depth[i]);
  }
  for (size_t i = 0; i < u_.size(); ++i) {
    if (!in_image(i) || occlusion.hides(u_[i], v_[i], depth[i])) continue;
    int32_t& seen = returns_[static_cast<size_t>(std::lround(v_[i])) * static_cast<size_t>(width_) +
                             static_cast<size_t>(std::lround(u_[i]))];
    if (seen < 0 || depth[i] < depth[static_cast<size_t>(seen)]) seen = static_cast<int32_t>(i);
  }
}

int32_t VisibleReturns::at(int column, int row) const {
  if (column < 0 || row < 0 || column >= width_ || row >= height_) return -1;
  return returns_[static_cast<size_t>(row) * static_cast<size_t>(width_) +
                  static_cast<size_t>(column)];
}

int32_t VisibleReturns::nearest(double u, double v, double radius) const {
  if (!(std::abs(u) < 1e6 && std::abs(v) < 1e6)) return -1;
  const auto reach = static_cast<int>(std::ceil(std::min(radius, 8.0)));
  const auto column = static_cast<int>(std::lround(u)), row = static_cast<int>(std::lround(v));
  int32_t best = -1;
  double least = radius;
  for (int r = row - reach; r <= row + reach; ++r) {
    for (int c = column - reach; c <= column + reach; ++c) {
      const int32_t i = at(c, r);
      if (i < 0) continue;
      const auto seen = static_cast<size_t>(i);
      const double distance = geometry::plane_length(u_[seen] - u, v_[seen] - v);
      if (distance > least) continue;
      least = distance;
      best = i;
    }
  }
  return best;
}

}  // namespace infuse::registration

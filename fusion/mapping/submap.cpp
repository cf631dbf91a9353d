#include "fusion/mapping/submap.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/registration/move_points.hpp"
#include "fusion/registration/voxel_key.hpp"

namespace infuse::mapping {

std::optional<std::string> SubmapOptions::invalid() const {
  if (!(voxel_size >= 0.05)) return "voxel_size must be at least 0.05 m";
  if (!(min_range >= 0)) return "min_range must not be negative";
  if (!(max_range > min_range && max_range <= 500)) return "max_range must be at most 500 m";
  return std::nullopt;
}

void Submap::resize(size_t points) {
  for (FieldVector<float>* field : {&x, &y, &z, &reflectivity}) field->resize(points);
}

void SubmapBuilder::add(const geometry::PointsView& points, std::span<const float> reflectivity,
                        const Eigen::Isometry3d& T_submap_lidar) {
  const size_t size = points.x.size();
  for (FieldVector<float>* field : {&x_, &y_, &z_}) field->resize(size);
  registration::move_points(T_submap_lidar, points, x_, y_, z_);
  const double min2 = options_.min_range * options_.min_range;
  const double max2 = options_.max_range * options_.max_range;
  for (size_t i = 0; i < size; ++i) {
    const Eigen::Vector3d p(x_[i], y_[i], z_[i]);
    const double range2 =
        Eigen::Vector3d(points.x[i], points.y[i], points.z[i]).squaredNorm();  // NaN is outside
    if (!(range2 >= min2 && range2 <= max2)) continue;
    const Eigen::Vector3d voxel = p / options_.voxel_size;
    const uint64_t key = registration::voxel_key(registration::floor_to_int(voxel.x()),
                                                 registration::floor_to_int(voxel.y()),
                                                 registration::floor_to_int(voxel.z()));
    const auto [at, is_new] = cell_of_.try_emplace(key, cells_.size());
    if (is_new) cells_.push_back({key, Eigen::Vector3d::Zero(), 0, 0});
    Cell& cell = cells_[at->second];
    cell.sum += p;
    cell.reflectivity += std::clamp(std::isfinite(reflectivity[i]) ? reflectivity[i] : 0, 0.F, 1.F);
    ++cell.count;
  }
}

Submap SubmapBuilder::take() {
  std::sort(cells_.begin(), cells_.end(),
            [](const Cell& a, const Cell& b) { return a.key < b.key; });
  Submap submap;
  submap.resize(cells_.size());
  const auto quantised = [](double value) {
    return static_cast<float>(std::round(value / kSubmapStep) * kSubmapStep);
  };
  for (size_t i = 0; i < cells_.size(); ++i) {
    const Cell& cell = cells_[i];
    submap.x[i] = quantised(cell.sum.x() / cell.count);
    submap.y[i] = quantised(cell.sum.y() / cell.count);
    submap.z[i] = quantised(cell.sum.z() / cell.count);
    submap.reflectivity[i] =
        static_cast<float>(std::round(255 * cell.reflectivity / cell.count) / 255);
  }
  cells_.clear();
  cell_of_.clear();
  return submap;
}

}  // namespace infuse::mapping

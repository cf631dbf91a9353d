#include "fusion/registration/voxel_downsample.hpp"

#include <algorithm>
#include <bit>

#include "fusion/registration/voxel_key.hpp"

namespace infuse::registration {

void VoxelDownsampler::compute(const geometry::PointsView& points, double voxel_size,
                               PointCloud& out, VoxelPoint which) {
  const size_t size = points.x.size();
  slots_.assign(std::bit_ceil(2 * size + 2), 0);
  cells_.clear();
  reserve_with_headroom(cells_, size);
  const size_t mask = slots_.size() - 1;
  const double scale = 1 / voxel_size;
  Cell* last = nullptr;
  for (size_t i = 0; i < size; ++i) {
    const double x = points.x[i] * scale, y = points.y[i] * scale, z = points.z[i] * scale;
    if (!is_voxel(x) || !is_voxel(y) || !is_voxel(z)) continue;
    const int32_t ix = floor_to_int(x), iy = floor_to_int(y), iz = floor_to_int(z);
    const uint64_t key = voxel_key(ix, iy, iz);
    if (last == nullptr || last->key != key) {
      size_t slot = voxel_hash(key) & mask;
      while (slots_[slot] != 0 && cells_[slots_[slot] - 1].key != key) slot = (slot + 1) & mask;
      if (slots_[slot] == 0) {
        cells_.push_back({key, 0, 0, 0, 0});
        slots_[slot] = static_cast<uint32_t>(cells_.size());
      }
      last = &cells_[slots_[slot] - 1];
    }
    if (which == VoxelPoint::kFirst && last->count > 0) continue;
    last->x += static_cast<float>(x - ix - 0.5);
    last->y += static_cast<float>(y - iy - 0.5);
    last->z += static_cast<float>(z - iz - 0.5);
    ++last->count;
  }

  out.resize(cells_.size());
  for (size_t i = 0; i < cells_.size(); ++i) {
    const Cell& cell = cells_[i];
    const auto mean = [&](int axis, float sum) {
      const double centre = voxel_coordinate(cell.key, axis) + 0.5;
      return static_cast<float>((centre + sum / cell.count) * voxel_size);
    };
    out.x[i] = mean(0, cell.x);
    out.y[i] = mean(1, cell.y);
    out.z[i] = mean(2, cell.z);
  }
  for (FieldVector<float>* normal : {&out.nx, &out.ny, &out.nz}) {
    std::fill(normal->begin(), normal->end(), 0.0F);
  }
}

PointCloud voxel_downsample(const geometry::PointsView& points, double voxel_size) {
  PointCloud out;
  VoxelDownsampler().compute(points, voxel_size, out);
  return out;
}

}  // namespace infuse::registration

#include "fusion/registration/voxel_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "drivers/measurement/simd.hpp"
#include "fusion/registration/lengths.hpp"
#include "fusion/registration/plane_fit.hpp"
#include "fusion/registration/voxel_key.hpp"

namespace infuse::registration {
namespace {

constexpr int kMoments = 1 + 3 + 6;  // by definition: weight, first and second moments

/// Sum over the lanes, in one order on every processor.
[[gnu::always_inline]] inline float sum(const Floats& v) {
  float total = 0;
  for (int lane = 0; lane < kLanes; ++lane) total += v[lane];
  return total;
}

/// Adds the moments of a voxel's points about a point, with the weights 1 − d²/r² inside the
/// radius; returns how many there are.
[[gnu::always_inline]] inline int add_moments(const VoxelMap::Voxel& voxel, const float* corner,
                                              float scale, Floats* moments) {
  const Floats dx = voxel.x + corner[0], dy = voxel.y + corner[1], dz = voxel.z + corner[2];
  const Floats weight = 1 - scale * (dx * dx + dy * dy + dz * dz);
  const Flags inside = weight > 0;
  const Floats w = inside ? weight : Floats{};
  // 0 · ∞ of unused entries is not a number: their coordinates are set to 0.
  const Floats x = inside ? dx : Floats{}, y = inside ? dy : Floats{}, z = inside ? dz : Floats{};
  moments[0] += w;
  moments[1] += w * x;
  moments[2] += w * y;
  moments[3] += w * z;
  moments[4] += w * x * x;
  moments[5] += w * x * y;
  moments[6] += w * x * z;
  moments[7] += w * y * y;
  moments[8] += w * y * z;
  moments[9] += w * z * z;
  int count = 0;
  for (int lane = 0; lane < kLanes; ++lane) count -= inside[lane];
  return count;
}

/// Voxels near a point: at most 27, with their corners relative to the point.
struct NearVoxels {
  int count = 0;
  const VoxelMap::Voxel* voxel[27];
  float corner[27][3];
};

INFUSE_SIMD_CLONES int sum_moments(const NearVoxels& near, float radius, float* out) {
  Floats moments[kMoments] = {};
  int count = 0;
  for (int i = 0; i < near.count; ++i) {
    count += add_moments(*near.voxel[i], near.corner[i], 1 / (radius * radius), moments);
  }
  for (int m = 0; m < kMoments; ++m) out[m] = sum(moments[m]);
  return count;
}

}  // namespace

std::optional<std::string> VoxelMapOptions::invalid() const {
  if (!(voxel_size > 0 && voxel_size <= 10)) return "voxel_size must be above 0 and at most 10 m";
  if (!(min_spacing >= 0 && min_spacing < voxel_size))
    return "min_spacing must be between 0 and voxel_size";
  if (!(range >= 10 * voxel_size)) return "range must be at least ten voxels";
  if (max_voxels < 1000) return "max_voxels must be at least 1000";
  if (min_points < 3) return "min_points must be at least 3";
  if (!(min_spread >= 0 && min_spread < 1)) return "min_spread must be between 0 and 1";
  return std::nullopt;
}

VoxelMap::VoxelMap(const VoxelMapOptions& options) : options_(options) {
  voxels_.reserve(options.max_voxels);
  slots_.assign(std::bit_ceil(2 * options.max_voxels), 0);
}

void VoxelMap::clear() {
  voxels_.clear();
  std::fill(slots_.begin(), slots_.end(), 0);
}

const VoxelMap::Voxel* VoxelMap::find(uint64_t key) const {
  const size_t mask = slots_.size() - 1;
  for (size_t slot = voxel_hash(key) & mask; slots_[slot] != 0; slot = (slot + 1) & mask) {
    const Voxel& voxel = voxels_[slots_[slot] - 1];
    if (voxel.key == key) return &voxel;
  }
  return nullptr;
}

VoxelMap::Voxel* VoxelMap::find_or_add(uint64_t key) {
  const size_t mask = slots_.size() - 1;
  size_t slot = voxel_hash(key) & mask;
  for (; slots_[slot] != 0; slot = (slot + 1) & mask) {
    Voxel& voxel = voxels_[slots_[slot] - 1];
    if (voxel.key == key) return &voxel;
  }
  if (voxels_.size() == options_.max_voxels) return nullptr;
  const Floats unused = Floats{} + std::numeric_limits<float>::infinity();
  voxels_.push_back({unused, unused, unused, key, 0});
  slots_[slot] = static_cast<uint32_t>(voxels_.size());
  return &voxels_.back();
}

void VoxelMap::insert(const geometry::PointsView& points, const Eigen::Isometry3d& T_map_lidar) {
  const double scale = 1 / options_.voxel_size;
  const auto spacing2 = static_cast<float>(options_.min_spacing * options_.min_spacing);
  for (size_t i = 0; i < points.x.size(); ++i) {
    const Eigen::Vector3d p = T_map_lidar * Eigen::Vector3d(points.x[i], points.y[i], points.z[i]);
    const Eigen::Vector3d at = p * scale;
    if (!is_voxel(at.x()) || !is_voxel(at.y()) || !is_voxel(at.z())) continue;
    const int32_t ix = floor_to_int(at.x()), iy = floor_to_int(at.y()), iz = floor_to_int(at.z());
    Voxel* voxel = find_or_add(voxel_key(ix, iy, iz));
    if (voxel == nullptr || voxel->count == kLanes) continue;
    const Eigen::Vector3d offset = p - options_.voxel_size * Eigen::Vector3d(ix, iy, iz);
    const Eigen::Vector3f o = offset.cast<float>();
    const Floats dx = voxel->x - o.x(), dy = voxel->y - o.y(), dz = voxel->z - o.z();
    const Flags close = dx * dx + dy * dy + dz * dz < spacing2;
    bool dense = false;
    for (int lane = 0; lane < kLanes; ++lane) dense |= close[lane] != 0;
    if (dense) continue;
    voxel->x[voxel->count] = o.x();
    voxel->y[voxel->count] = o.y();
    voxel->z[voxel->count] = o.z();
    ++voxel->count;
  }
}

void VoxelMap::drop_far(const Eigen::Vector3d& position) {
  const Eigen::Vector3d centre = position / options_.voxel_size - Eigen::Vector3d::Constant(0.5);
  const double range = options_.range / options_.voxel_size;
  const auto far = [&](const Voxel& voxel) {
    const Eigen::Vector3d corner(voxel_coordinate(voxel.key, 0), voxel_coordinate(voxel.key, 1),
                                 voxel_coordinate(voxel.key, 2));
    return (corner - centre).squaredNorm() > range * range;
  };
  const auto kept = std::remove_if(voxels_.begin(), voxels_.end(), far);
  if (kept == voxels_.end()) return;
  voxels_.erase(kept, voxels_.end());
  rebuild_slots();
}

void VoxelMap::rebuild_slots() {
  std::fill(slots_.begin(), slots_.end(), 0);
  const size_t mask = slots_.size() - 1;
  for (size_t i = 0; i < voxels_.size(); ++i) {
    size_t slot = voxel_hash(voxels_[i].key) & mask;
    while (slots_[slot] != 0) slot = (slot + 1) & mask;
    slots_[slot] = static_cast<uint32_t>(i + 1);
  }
}

Eigen::Vector3d VoxelMap::anchor(const Eigen::Vector3d& position) const {
  return (position / options_.voxel_size).array().floor() * options_.voxel_size;
}

void VoxelMap::find_planes(const Eigen::Vector3d& anchor, double radius,
                           const std::vector<int32_t>& which, Pairs& pairs) const {
  const double size = options_.voxel_size;
  const Eigen::Vector3i base = (anchor / size).array().round().cast<int32_t>();
  const auto gather = [&](const float* p, NearVoxels& near) {
    int32_t low[3], high[3];
    near.count = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (!is_voxel(p[axis] / size + base[axis])) return;
      low[axis] = floor_to_int((p[axis] - radius) / size);
      high[axis] = std::min(floor_to_int((p[axis] + radius) / size), low[axis] + 2);
    }
    for (int32_t z = low[2]; z <= high[2]; ++z) {
      for (int32_t y = low[1]; y <= high[1]; ++y) {
        for (int32_t x = low[0]; x <= high[0]; ++x) {
          const Voxel* voxel = find(voxel_key(x + base[0], y + base[1], z + base[2]));
          if (voxel == nullptr) continue;
          near.voxel[near.count] = voxel;
          const int32_t at[3] = {x, y, z};
          for (int axis = 0; axis < 3; ++axis) {
            near.corner[near.count][axis] = static_cast<float>(at[axis] * size - p[axis]);
          }
          ++near.count;
        }
      }
    }
  };
  NearVoxels near;
  for (size_t begin = 0; begin < which.size(); begin += kPlanes) {
    const int count = static_cast<int>(std::min<size_t>(kPlanes, which.size() - begin));
    Covariances covariances = {};
    float mean[kPlanes][3] = {};
    double share[kPlanes] = {};  // of one point
    for (int lane = 0; lane < count; ++lane) {
      const auto i = static_cast<size_t>(which[begin + static_cast<size_t>(lane)]);
      const float p[3] = {pairs.px[i], pairs.py[i], pairs.pz[i]};
      gather(p, near);
      float moments[kMoments];
      if (sum_moments(near, static_cast<float>(radius), moments) < options_.min_points) continue;
      const double w = share[lane] = 1 / static_cast<double>(moments[0]);
      const double m[3] = {moments[1] * w, moments[2] * w, moments[3] * w};
      constexpr int kRow[6] = {0, 0, 0, 1, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 2};
      for (size_t e = 0; e < 6; ++e) {
        covariances[e][lane] = moments[4 + e] * w - m[kRow[e]] * m[kColumn[e]];
      }
      for (int axis = 0; axis < 3; ++axis) mean[lane][axis] = static_cast<float>(m[axis]);
    }
    const PlaneFits planes = fit_planes(covariances, options_.min_spread);
    for (int lane = 0; lane < count; ++lane) {
      const auto i = static_cast<size_t>(which[begin + static_cast<size_t>(lane)]);
      const auto nx = static_cast<float>(planes.normal[0][lane]);
      const auto ny = static_cast<float>(planes.normal[1][lane]);
      const auto nz = static_cast<float>(planes.normal[2][lane]);
      const float distance = nx * mean[lane][0] + ny * mean[lane][1] + nz * mean[lane][2];
      pairs.tx[i] = nx;
      pairs.ty[i] = ny;
      pairs.tz[i] = nz;
      pairs.qx[i] = pairs.px[i] + distance * nx;
      pairs.qy[i] = pairs.py[i] + distance * ny;
      pairs.qz[i] = pairs.pz[i] + distance * nz;
      // Planarity: 1 − the variance across in units of the mean variance along, at least 0.
      const bool plane = planes.others[lane] > 0 && (nx != 0 || ny != 0 || nz != 0);
      const double flat = plane ? 1 - 2 * planes.smallest[lane] / planes.others[lane] : 0;
      pairs.weight[i] = static_cast<float>(std::max(flat, 0.0) * std::max(flat, 0.0));
      // A variance λ₀ across n points tilts their plane by λ₀/n (1/λ₁ + 1/λ₂).
      // Few points may lie on a plane by chance.
      const double across = std::max(planes.smallest[lane], kRangeNoise * kRangeNoise);
      const double by_noise = across * share[lane] * planes.others[lane] / planes.product[lane];
      pairs.tilt[i] = plane ? static_cast<float>(by_noise) : 0;
    }
  }
}

}  // namespace infuse::registration

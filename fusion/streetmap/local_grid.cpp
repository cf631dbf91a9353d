#include "fusion/streetmap/local_grid.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "fusion/geometry/project_points.hpp"

namespace infuse::streetmap {
namespace {

/// Steps between adjacent columns, of all returns.
constexpr features::DiscontinuityOptions kDiscontinuityOptions{
    .max_gap = 0.1, .max_column_gap = 1, .max_step = 25, .max_edge_azimuth = 0};

/// Cells are pixels of the features' image; on flat ground one spans a quarter of the depth: hidden
/// is what lies more than 0.5 m and that quarter behind the nearest.
constexpr features::OcclusionOptions kOcclusionOptions{
    .cell_size = 8, .ratio = 1 / 0.75, .step = 0.5 / 0.75, .with_neighbours = false};

float signed_sqrt(float height) { return std::copysign(std::sqrt(std::abs(height)), height); }

}  // namespace

std::optional<std::string> LocalGridOptions::invalid() const {
  if (!(cell_size >= 0.02 && cell_size <= 1))
    return "the local grid's cell_size must be between 0.02 and 1 m";
  if (!(extent >= 10 * cell_size && extent / cell_size <= 4000)) {
    return "the local grid's extent must be between 10 and 4000 cells";
  }
  if (block_size < 1 || block_size > 32)
    return "the local grid's block_size must be between 1 and 32 cells";
  if (!(min_height < max_height)) return "the local grid's min_height must be below its max_height";
  if (!(min_range >= 0)) return "the local grid's min_range must not be negative";
  if (mean_window < 1) return "the local grid's mean_window must be at least 1";
  if (max_samples < 50) return "the local grid's max_samples must be at least 50";
  return std::nullopt;
}

LocalGrid::LocalGrid(const LocalGridOptions& options)
    : options_(options),
      cells_per_edge_(static_cast<int>(std::ceil(options.extent / options.cell_size))),
      discontinuities_(kDiscontinuityOptions),
      occlusion_(kOcclusionOptions) {
  grid_.resize(static_cast<size_t>(cells_per_edge_) * static_cast<size_t>(cells_per_edge_));
  const auto blocks = static_cast<size_t>(cells_per_edge_ / options.block_size + 2);
  blocks_.reserve(blocks * blocks);
}

void LocalGrid::clear() { std::fill(grid_.begin(), grid_.end(), Cell{}); }

LocalGrid::Cell& LocalGrid::cell_at(int32_t column, int32_t row) {
  const auto wrap = [&](int32_t k) {
    const int32_t rest = k % cells_per_edge_;
    return static_cast<size_t>(rest < 0 ? rest + cells_per_edge_ : rest);
  };
  return grid_[wrap(row) * static_cast<size_t>(cells_per_edge_) + wrap(column)];
}

void LocalGrid::project(const DeskewedView& deskewed, const ImageView& image) {
  const size_t n = deskewed.x.size();
  u_.resize(n);
  v_.resize(n);
  depth_.resize(n);
  geometry::project_points(image.camera, image.T_camera_lidar, {deskewed.x, deskewed.y, deskewed.z},
                           {u_, v_, depth_});
  // Pixels of the feature image, which may be reduced.
  const float fx = static_cast<float>(image.features.width) /
                   static_cast<float>(image.camera.intrinsics().width);
  const float fy = static_cast<float>(image.features.height) /
                   static_cast<float>(image.camera.intrinsics().height);
  occlusion_.reset(image.features.width, image.features.height);
  for (size_t i = 0; i < n; ++i) {
    const float u = (u_[i] + 0.5F) * fx, v = (v_[i] + 0.5F) * fy;
    const bool inside = depth_[i] > 0.1F && u >= 0 && v >= 0 &&
                        u < static_cast<float>(image.features.width) &&
                        v < static_cast<float>(image.features.height);
    if (!inside) {
      depth_[i] = -1;
      continue;
    }
    u_[i] = u;
    v_[i] = v;
    occlusion_.add(u, v, depth_[i]);
  }
}

bool LocalGrid::visible(size_t i) const {
  return depth_[i] >= 0 && !occlusion_.hides(u_[i], v_[i], depth_[i]);
}

void LocalGrid::add(const DeskewedView& deskewed, const ImageView* image, const PlanarPose& pose) {
  const size_t n = deskewed.x.size();
  const Sweep& sweep = deskewed.sweep;
  const std::vector<float>& discontinuity =
      discontinuities_.compute({{deskewed.x, deskewed.y, deskewed.z},
                                sweep.range,
                                sweep.reflectivity,
                                sweep.ring,
                                sweep.column});
  if (image != nullptr) project(deskewed, *image);
  const Eigen::Matrix3f R = deskewed.T_vehicle_lidar.linear().cast<float>();
  const Eigen::Vector3f t = deskewed.T_vehicle_lidar.translation().cast<float>();
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  const auto half = static_cast<float>(options_.extent / 2);
  const auto low = static_cast<float>(options_.min_height),
             high = static_cast<float>(options_.max_height);
  const auto near = static_cast<float>(options_.min_range);
  const auto max_count = static_cast<float>(options_.mean_window);
  for (size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f p = R * Eigen::Vector3f(deskewed.x[i], deskewed.y[i], deskewed.z[i]) + t;
    const bool in_range = p.z() > low && p.z() < high && std::abs(p.x()) < half &&
                          std::abs(p.y()) < half && sweep.range[i] > near;
    if (!in_range) continue;
    const double x = pose.x + c * p.x() - s * p.y(), y = pose.y + s * p.x() + c * p.y();
    const auto column = static_cast<int32_t>(std::floor(x / options_.cell_size));
    const auto row = static_cast<int32_t>(std::floor(y / options_.cell_size));
    Cell& cell = cell_at(column, row);
    if (cell.column != column || cell.row != row) {
      cell = {};
      cell.column = column;
      cell.row = row;
    }
    cell.lidar_count = std::min(cell.lidar_count + 1, max_count);
    const float share = 1 / cell.lidar_count;
    cell.mean[kHeight] += share * (signed_sqrt(p.z()) - cell.mean[kHeight]);
    cell.mean[kDiscontinuity] += share * (discontinuity[i] - cell.mean[kDiscontinuity]);
    cell.mean[kReflectivity] += share * (sweep.reflectivity[i] - cell.mean[kReflectivity]);
    if (image == nullptr || !visible(i)) continue;
    const auto& pixel = image->features.at(static_cast<int>(u_[i]), static_cast<int>(v_[i]));
    cell.colour_count = std::min(cell.colour_count + 1, max_count);
    for (size_t k = 0; k < 4; ++k) {
      float& mean = cell.mean[static_cast<size_t>(kBlue) + k];
      mean += (pixel[k] - mean) / cell.colour_count;
    }
  }
}

void LocalGrid::gather_blocks(const PlanarPose& pose) {
  blocks_.clear();
  const double edge = options_.cell_size * options_.block_size, half = options_.extent / 2;
  const int reach = static_cast<int>(std::floor(half / edge));
  const auto middle_column = static_cast<int32_t>(std::floor(pose.x / edge));
  const auto middle_row = static_cast<int32_t>(std::floor(pose.y / edge));
  const double c = std::cos(pose.yaw), s = std::sin(pose.yaw);
  for (int32_t r = middle_row - reach; r < middle_row + reach; ++r) {
    for (int32_t k = middle_column - reach; k < middle_column + reach; ++k) {
      Block block{};
      float lidar = 0, colour = 0;
      for (int i = 0; i < options_.block_size * options_.block_size; ++i) {
        const int32_t column = k * options_.block_size + i % options_.block_size;
        const int32_t row = r * options_.block_size + i / options_.block_size;
        const Cell& cell = cell_at(column, row);
        if (cell.column != column || cell.row != row) continue;
        ++lidar;
        for (size_t f = 0; f < kLidarFeatureCount; ++f) block.mean[f] += cell.mean[f];
        if (cell.colour_count == 0) continue;
        ++colour;
        for (size_t f = kLidarFeatureCount; f < kFeatureCount; ++f) block.mean[f] += cell.mean[f];
      }
      if (lidar == 0) continue;
      for (size_t f = 0; f < kLidarFeatureCount; ++f) block.mean[f] /= lidar;
      block.coloured = colour > 0;
      for (size_t f = kLidarFeatureCount; f < kFeatureCount && colour > 0; ++f)
        block.mean[f] /= colour;
      const double dx = (k + 0.5) * edge - pose.x, dy = (r + 0.5) * edge - pose.y;
      block.x = static_cast<float>(c * dx + s * dy);
      block.y = static_cast<float>(-s * dx + c * dy);
      blocks_.push_back(block);
    }
  }
}

void LocalGrid::draw_samples(const PlanarPose& pose, GridSamples& samples) {
  gather_blocks(pose);
  // A random choice that depends on the seed and the number of draws only.
  const auto max_samples = static_cast<size_t>(options_.max_samples);
  std::mt19937_64 random(options_.seed + 0x9E3779B97F4A7C15 * ++draws_);
  for (size_t i = 0; i < max_samples && blocks_.size() > max_samples; ++i) {
    std::swap(blocks_[i], blocks_[i + random() % (blocks_.size() - i)]);
  }
  if (blocks_.size() > max_samples) blocks_.resize(max_samples);
  standardise(samples);
}

void LocalGrid::standardise(GridSamples& samples) const {
  const size_t n = blocks_.size();
  samples.x.resize(n);
  samples.y.resize(n);
  size_t coloured = 0;
  for (size_t i = 0; i < n; ++i) {
    samples.x[i] = blocks_[i].x;
    samples.y[i] = blocks_[i].y;
    coloured += blocks_[i].coloured;
  }
  // If less than a tenth has a colour, colour shows the field of view rather than the ground.
  const int columns = coloured * 10 >= n && coloured > 0 ? kFeatureCount : kLidarFeatureCount;
  samples.features.resize(static_cast<Eigen::Index>(n), columns);
  for (int f = 0; f < columns; ++f) {
    const auto feature = static_cast<size_t>(f);
    double count = 0, sum = 0, squares = 0;
    for (const Block& block : blocks_) {
      if (f >= kLidarFeatureCount && !block.coloured) continue;
      const double value = block.mean[feature];
      ++count;
      sum += value;
      squares += value * value;
    }
    const double mean = count > 0 ? sum / count : 0;
    const double sigma = std::sqrt(std::max(squares / std::max(count, 1.0) - mean * mean, 0.0));
    const double scale = sigma > 1e-6 ? 1 / sigma : 0;
    for (size_t i = 0; i < n; ++i) {
      const bool known = f < kLidarFeatureCount || blocks_[i].coloured;
      samples.features(static_cast<Eigen::Index>(i), f) =
          known ? std::clamp((blocks_[i].mean[feature] - mean) * scale, -3.0, 3.0) : 0.0;
    }
  }
}

}  // namespace infuse::streetmap

#include "fusion/calibration/visible_points.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "fusion/geometry/project_points.hpp"

namespace infuse::calibration {
namespace {

/// Smallest depth by cell, with a border of one cell around the picture.
class DepthBuffer {
 public:
  explicit DepthBuffer(double cell) : cell_(static_cast<float>(cell)) {}

  /// Empty, for pictures of this size.
  void resize(int width, int height) {
    columns_ = static_cast<int>(static_cast<float>(width) / cell_) + 3;
    rows_ = static_cast<int>(static_cast<float>(height) / cell_) + 3;
    nearest_.resize(static_cast<size_t>(columns_) * static_cast<size_t>(rows_), kEmpty);
  }
  void add(float u, float v, float depth) {
    float& cell = nearest_[at(column(u), row(v))];
    cell = std::min(cell, depth);
  }
  /// Empties the cell: far cheaper than all of them, where points are few.
  void clear_cell(float u, float v) { nearest_[at(column(u), row(v))] = kEmpty; }

  float nearest_around(float u, float v) const {
    const int left = column(u) - 1;
    const int top = row(v) - 1;
    float nearest = kEmpty;
    for (int dy = 0; dy < 3; ++dy) {
      const float* cells = &nearest_[at(left, top + dy)];
      nearest = std::min({nearest, cells[0], cells[1], cells[2]});
    }
    return nearest;
  }

 private:
  static constexpr float kEmpty = std::numeric_limits<float>::infinity();

  int column(float u) const { return std::clamp(static_cast<int>(u / cell_) + 1, 1, columns_ - 2); }
  int row(float v) const { return std::clamp(static_cast<int>(v / cell_) + 1, 1, rows_ - 2); }
  size_t at(int column, int row) const { return static_cast<size_t>(row * columns_ + column); }

  float cell_;
  int columns_ = 0, rows_ = 0;
  std::vector<float> nearest_;
};

struct Pixels {
  std::vector<float> u, v, depth;
};

Pixels project(const Scene& scene, const RigCamera& camera, const Eigen::Isometry3d& T_head_lidar) {
  const size_t n = scene.size();
  Pixels pixels{std::vector<float>(n), std::vector<float>(n), std::vector<float>(n)};
  geometry::project_points(camera.model, camera.T_camera_refcam * T_head_lidar,
                           {scene.x, scene.y, scene.z}, {pixels.u, pixels.v, pixels.depth});
  return pixels;
}

std::vector<size_t> indices_in_image(const Pixels& pixels, const CameraIntrinsics& image,
                                     double min_depth) {
  const auto right = static_cast<float>(image.width - 1);
  const auto bottom = static_cast<float>(image.height - 1);
  std::vector<size_t> view;
  for (size_t i = 0; i < pixels.u.size(); ++i) {
    // NaN where the model does not see the point: no comparison holds.
    if (pixels.u[i] >= 0 && pixels.u[i] <= right && pixels.v[i] >= 0 && pixels.v[i] <= bottom &&
        pixels.depth[i] >= static_cast<float>(min_depth)) {
      view.push_back(i);
    }
  }
  return view;
}

/// `buffer`: empty before and after.
void remove_occluded(std::vector<size_t>& view, const Pixels& pixels, const CameraIntrinsics& image,
                     const VisibilityOptions& options, DepthBuffer& buffer) {
  buffer.resize(image.width, image.height);
  for (const size_t i : view) buffer.add(pixels.u[i], pixels.v[i], pixels.depth[i]);
  const std::vector<size_t> added = view;
  const auto ratio = static_cast<float>(options.occlusion_ratio);
  const auto step = static_cast<float>(options.occlusion_step);
  std::erase_if(view, [&](size_t i) {
    return pixels.depth[i] > buffer.nearest_around(pixels.u[i], pixels.v[i]) * ratio + step;
  });
  for (const size_t i : added) buffer.clear_cell(pixels.u[i], pixels.v[i]);
}

/// Indices of the scene's points that are in view under every pose.
std::vector<size_t> visible_indices(const Scene& scene, const RigCamera& camera,
                                    std::span<const Eigen::Isometry3d> poses,
                                    const VisibilityOptions& options, DepthBuffer& buffer) {
  const CameraIntrinsics& image = camera.model.intrinsics();
  std::vector<size_t> common;
  for (size_t k = 0; k < poses.size(); ++k) {
    const Pixels pixels = project(scene, camera, poses[k]);
    std::vector<size_t> view = indices_in_image(pixels, image, options.min_depth);
    if (options.occlusion_cell > 0) remove_occluded(view, pixels, image, options, buffer);
    if (k == 0) {
      common = std::move(view);
    } else {
      std::vector<size_t> both;
      std::set_intersection(common.begin(), common.end(), view.begin(), view.end(),
                            std::back_inserter(both));
      common = std::move(both);
    }
  }
  return common;
}

}  // namespace

std::optional<std::string> VisibilityOptions::invalid() const {
  if (!(min_depth > 0)) return "min_depth must be positive";
  if (!(occlusion_cell == 0 || occlusion_cell >= 1))
    return "occlusion_cell must be 0 or at least 1";
  if (!(occlusion_ratio >= 1)) return "occlusion_ratio must be at least 1";
  if (!(occlusion_step >= 0)) return "occlusion_step must not be negative";
  return std::nullopt;
}

VisiblePoints select_visible(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                             std::span<const Eigen::Isometry3d> poses,
                             const VisibilityOptions& options) {
  std::vector<std::vector<size_t>> views;
  DepthBuffer buffer(options.occlusion_cell);
  size_t all = 0;
  for (const Scene& scene : scenes) {
    views.push_back(visible_indices(scene, cameras[scene.camera], poses, options, buffer));
    all += views.back().size();
  }
  const size_t stride =
      options.max_points == 0
          ? 1
          : std::max<size_t>(1, (all + options.max_points - 1) / options.max_points);
  VisiblePoints points;
  for (size_t s = 0; s < scenes.size(); ++s) {
    const auto append = [&](const std::vector<float>& from, std::vector<float>& to) {
      for (size_t k = 0; !from.empty() && k < views[s].size(); k += stride)
        to.push_back(from[views[s][k]]);
    };
    const size_t begin = points.size();
    append(scenes[s].x, points.x);
    append(scenes[s].y, points.y);
    append(scenes[s].z, points.z);
    for (size_t f = 0; f < kLidarFeatures; ++f) append(scenes[s].lidar[f], points.lidar[f]);
    points.blocks.push_back({.scene = s, .begin = begin, .end = points.size()});
  }
  return points;
}

VisiblePoints select_visible(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                             const Eigen::Isometry3d& T_head_lidar,
                             const VisibilityOptions& options) {
  return select_visible(scenes, cameras, std::span(&T_head_lidar, 1), options);
}

VisiblePoints select_blocks(const VisiblePoints& points,
                            std::span<const VisiblePoints::Block> blocks) {
  const size_t first = blocks.front().begin;
  const auto cut = [&](const std::vector<float>& all) {
    if (all.empty()) return std::vector<float>();
    return std::vector<float>(all.begin() + static_cast<std::ptrdiff_t>(first),
                              all.begin() + static_cast<std::ptrdiff_t>(blocks.back().end));
  };
  VisiblePoints part{.x = cut(points.x), .y = cut(points.y), .z = cut(points.z)};
  for (size_t f = 0; f < kLidarFeatures; ++f) part.lidar[f] = cut(points.lidar[f]);
  for (const VisiblePoints::Block& block : blocks) {
    part.blocks.push_back({block.scene, block.begin - first, block.end - first});
  }
  return part;
}

}  // namespace infuse::calibration

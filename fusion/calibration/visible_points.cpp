#include "fusion/calibration/visible_points.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "fusion/geometry/project_points.hpp"

namespace infuse::calibration {
namespace {

struct Pixels {
  std::vector<float> u, v, depth;
};

Pixels project(const Scene& scene, const RigCamera& camera,
               const Eigen::Isometry3d& T_refcam_lidar) {
  const size_t n = scene.size();
  Pixels pixels{std::vector<float>(n), std::vector<float>(n), std::vector<float>(n)};
  geometry::project_points(camera.model, camera.T_camera_refcam * T_refcam_lidar,
                           {scene.x, scene.y, scene.z}, {pixels.u, pixels.v, pixels.depth});
  return pixels;
}

std::vector<size_t> indices_in_image(const Pixels& pixels, const CameraIntrinsics& image,
                                     double min_depth) {
  const auto right = static_cast<float>(image.width - 1);
  const auto bottom = static_cast<float>(image.height - 1);
  std::vector<size_t> view;
  for (size_t i = 0; i < pixels.u.size(); ++i) {
    // NaN where the model does not see the point: all comparisons are false.
    if (pixels.u[i] >= 0 && pixels.u[i] <= right && pixels.v[i] >= 0 && pixels.v[i] <= bottom &&
        pixels.depth[i] >= static_cast<float>(min_depth)) {
      view.push_back(i);
    }
  }
  return view;
}

/// Removes the points that others hide. `buffer` is empty before and after.
void remove_occluded(std::vector<size_t>& view, const Pixels& pixels,
                     features::OcclusionBuffer& buffer) {
  for (const size_t i : view) buffer.add(pixels.u[i], pixels.v[i], pixels.depth[i]);
  const std::vector<size_t> added = view;
  std::erase_if(view,
                [&](size_t i) { return buffer.hides(pixels.u[i], pixels.v[i], pixels.depth[i]); });
  for (const size_t i : added) buffer.clear_cell(pixels.u[i], pixels.v[i]);
}

/// Indices of the scene's points that are in view under every pose.
std::vector<size_t> visible_indices(const Scene& scene, const RigCamera& camera,
                                    std::span<const Eigen::Isometry3d> poses,
                                    const VisibilityOptions& options,
                                    std::optional<features::OcclusionBuffer>& buffer) {
  const CameraIntrinsics& image = camera.model.intrinsics();
  std::vector<size_t> common;
  for (size_t k = 0; k < poses.size(); ++k) {
    const Pixels pixels = project(scene, camera, poses[k]);
    std::vector<size_t> view = indices_in_image(pixels, image, options.min_depth);
    if (buffer) remove_occluded(view, pixels, *buffer);
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
  if (occlusion) return occlusion->invalid();
  return std::nullopt;
}

VisiblePoints select_visible(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                             std::span<const Eigen::Isometry3d> poses,
                             const VisibilityOptions& options) {
  std::vector<std::vector<size_t>> views;
  std::vector<std::optional<features::OcclusionBuffer>> buffers(cameras.size());
  for (size_t c = 0; options.occlusion && c < cameras.size(); ++c) {
    const CameraIntrinsics& image = cameras[c].model.intrinsics();
    buffers[c].emplace(*options.occlusion).reset(image.width, image.height);
  }
  size_t all = 0;
  for (const Scene& scene : scenes) {
    views.push_back(
        visible_indices(scene, cameras[scene.camera], poses, options, buffers[scene.camera]));
    all += views.back().size();
  }
  const size_t stride =
      options.max_points == 0
          ? 1
          : std::max<size_t>(1, (all + options.max_points - 1) / options.max_points);
  const size_t kept = all / stride + scenes.size();  // at most, so that nothing grows by doubling
  VisiblePoints points;
  for (size_t s = 0; s < scenes.size(); ++s) {
    const auto append = [&](const std::vector<float>& from, std::vector<float>& to) {
      if (!from.empty()) to.reserve(kept);
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
                             const Eigen::Isometry3d& T_refcam_lidar,
                             const VisibilityOptions& options) {
  return select_visible(scenes, cameras, std::span(&T_refcam_lidar, 1), options);
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

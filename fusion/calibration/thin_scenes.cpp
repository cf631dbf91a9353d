#include "fusion/calibration/thin_scenes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "fusion/geometry/project_points.hpp"

namespace infuse::calibration {
namespace {

/// Returns the largest angle between the optical axis and the image's border.
double half_field_of_view(const geometry::CameraModel& model) {
  constexpr int kBorderSteps = 8;
  const double right = model.intrinsics().width - 1;
  const double bottom = model.intrinsics().height - 1;
  double widest = 0;
  for (int k = 0; k <= kBorderSteps; ++k) {
    const double part = static_cast<double>(k) / kBorderSteps;
    for (const Eigen::Vector2d& pixel :
         {Eigen::Vector2d(part * right, 0), Eigen::Vector2d(part * right, bottom),
          Eigen::Vector2d(0, part * bottom), Eigen::Vector2d(right, part * bottom)}) {
      // The model does not reach the border: all points in front of the camera may be in view.
      const auto along = model.unproject(pixel);
      widest = std::max(widest, along ? std::acos(std::clamp(along->z(), -1.0, 1.0)) : M_PI / 2);
    }
  }
  return widest;
}

constexpr double kNearEdgeWeight = 4;  // of a point near a depth edge; other points have 1

bool near_edge(const Scene& scene, size_t i) {
  for (const auto feature : {LidarFeature::kDiscontinuity, LidarFeature::kRelativeDiscontinuity}) {
    const std::vector<float>& edge = scene.lidar[index(feature)];
    if (!edge.empty() && !std::isnan(edge[i])) return true;
  }
  return false;
}

/// Indices of the points within `angle` of the camera's axis, and the numbers of those within
/// `inner` that are near depth edges and that are not.
struct Cone {
  std::vector<size_t> points;
  size_t near_edge_count = 0, other_count = 0;
};

Cone points_in_cone(const Scene& scene, const Eigen::Isometry3d& T, double angle, double inner) {
  const double min_cosine = std::cos(std::min(angle, M_PI));
  const double min_inner_cosine = std::cos(std::min(inner, M_PI));
  Cone cone;
  for (size_t i = 0; i < scene.size(); ++i) {
    const Eigen::Vector3d p = T * Eigen::Vector3d(scene.x[i], scene.y[i], scene.z[i]);
    const double range = p.norm();
    if (p.z() < min_cosine * range) continue;
    cone.points.push_back(i);
    if (p.z() >= min_inner_cosine * range)
      ++(near_edge(scene, i) ? cone.near_edge_count : cone.other_count);
  }
  return cone;
}

/// Keeps one point per step of weight.
class EvenChoice {
 public:
  explicit EvenChoice(double step) : step_(step), due_(step / 2) {}

  bool keeps(double weight) {
    due_ += weight;
    if (due_ < step_) return false;
    due_ = std::min(due_ - step_, step_);
    return true;
  }

 private:
  double step_, due_;
};

/// Considers this share of the points, of those near edges as of the others. Of these it keeps one
/// per `step` of weight; with `keep_edges` all those near edges, and one per `step` of the others.
std::vector<size_t> thin_points(double step, double share, bool keep_edges, const Scene& scene,
                                const std::vector<size_t>& points) {
  std::vector<size_t> kept;
  EvenChoice considered_edges(1), considered_others(1), choice(step);
  for (const size_t i : points) {
    const bool near = near_edge(scene, i);
    if (!(near ? considered_edges : considered_others).keeps(share)) continue;
    if ((near && keep_edges) || choice.keeps(near ? kNearEdgeWeight : 1)) kept.push_back(i);
  }
  return kept;
}

/// Returns the given points of a scene, in that order.
Scene select_points(const Scene& scene, const std::vector<size_t>& points) {
  Scene part{.name = scene.name, .camera = scene.camera, .twist = scene.twist};
  const auto copy_values = [&](const std::vector<float>& from, std::vector<float>& to) {
    if (from.empty()) return;
    to.reserve(points.size());
    for (const size_t i : points) to.push_back(from[i]);
  };
  copy_values(scene.x, part.x);
  copy_values(scene.y, part.y);
  copy_values(scene.z, part.z);
  for (size_t f = 0; f < kLidarFeatures; ++f) copy_values(scene.lidar[f], part.lidar[f]);
  return part;
}

/// Sorts the scene's points by strips of the image, from its top to its bottom: consecutive
/// look-ups then hit the processor's cache.
Scene sort_by_strips(const Scene& scene, const geometry::CameraModel& model,
                     const Eigen::Isometry3d& T_camera_lidar) {
  constexpr float kStripHeight = 8;  // px, of rows in the cache
  const size_t n = scene.size();
  std::vector<float> u(n), v(n), depth(n);
  geometry::project_points(model, T_camera_lidar, {scene.x, scene.y, scene.z}, {u, v, depth});
  const auto strips = static_cast<float>(model.intrinsics().height) / kStripHeight;
  std::vector<std::pair<float, float>> place(n);  // the strip, then along it
  for (size_t i = 0; i < n; ++i) {
    const bool seen = !std::isnan(v[i]);
    place[i] = {seen ? std::floor(std::clamp(v[i] / kStripHeight, -1.0F, strips)) : strips + 1,
                seen ? u[i] : 0.0F};
  }
  std::vector<size_t> order(n);
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return place[a] < place[b]; });
  return select_points(scene, order);
}

}  // namespace

std::vector<Scene> thin_scenes(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                               const Eigen::Isometry3d& T_refcam_lidar, double margin,
                               size_t points, bool keep_edges, const Eigen::VectorXd& weights) {
  const auto weight = [&](size_t s) {
    return weights.size() == 0 ? 1.0 : weights(static_cast<Eigen::Index>(s));
  };
  std::vector<Cone> cones;
  double in_view = 0;
  for (const Scene& scene : scenes) {
    const RigCamera& camera = cameras[scene.camera];
    const double half = half_field_of_view(camera.model);
    cones.push_back(
        points_in_cone(scene, camera.T_camera_refcam * T_refcam_lidar, half + margin, half));
    const double near =
        keep_edges ? 0 : kNearEdgeWeight * static_cast<double>(cones.back().near_edge_count);
    in_view += weight(cones.size() - 1) * (near + static_cast<double>(cones.back().other_count));
  }
  const double step = std::max(1.0, in_view / static_cast<double>(std::max<size_t>(points, 1)));
  std::vector<Scene> thin;
  for (size_t s = 0; s < scenes.size(); ++s) {
    const RigCamera& camera = cameras[scenes[s].camera];
    const Scene part = select_points(
        scenes[s], thin_points(step, weight(s), keep_edges, scenes[s], cones[s].points));
    thin.push_back(sort_by_strips(part, camera.model, camera.T_camera_refcam * T_refcam_lidar));
  }
  return thin;
}

void keep_points_near(Scene& scene, const RigCamera& camera,
                      const Eigen::Isometry3d& T_refcam_lidar, double margin) {
  const double half = half_field_of_view(camera.model);
  const Cone cone =
      points_in_cone(scene, camera.T_camera_refcam * T_refcam_lidar, half + margin, half);
  Scene part = select_points(scene, cone.points);
  scene.x = std::move(part.x);
  scene.y = std::move(part.y);
  scene.z = std::move(part.z);
  scene.lidar = std::move(part.lidar);
}

}  // namespace infuse::calibration

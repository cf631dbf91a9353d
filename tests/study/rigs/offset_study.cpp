#include "tests/study/rigs/offset_study.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "daemon/playback/calibration_scenes.hpp"
#include "daemon/tools/calibrate/calibration_run.hpp"
#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/compare_extrinsics.hpp"

namespace infuse::study {
namespace {

using calibration::ImageFeature;
using calibration::LidarFeature;
using calibration::Scene;

constexpr float kEdgeRank =
    0.7F;  // returns with larger steps than that share of their ring's edges

/// Mean change of grey per pixel (of 255) at the strong depth edges of each scene.
std::vector<double> edge_strengths(const std::vector<Scene>& scenes,
                                   std::span<const calibration::RigCamera> cameras,
                                   std::span<const Eigen::Isometry3d> poses, size_t which) {
  const std::vector<calibration::TermOptions> terms{
      {.lidar = {LidarFeature::kRelativeDiscontinuity},
       .image = {ImageFeature::kEdge},
       .equalize = false}};
  std::vector<double> all;
  for (const Scene& scene : scenes) {
    const std::span<const Scene> one(&scene, 1);
    const calibration::VisiblePoints points = calibration::select_visible(one, cameras, poses, {});
    const calibration::BlurredImages images(one, cameras, terms,
                                            calibration::ImageBlur::in_angle(1));
    calibration::Objective objective(points, images, cameras, one, terms);
    const auto samples = objective.samples(poses[which], 0);
    double sum = 0, count = 0;
    for (size_t i = 0; i < samples.lidar.size(); ++i) {
      if (!(samples.lidar[i] > kEdgeRank) || !std::isfinite(samples.image[i])) continue;
      sum += static_cast<double>(samples.image[i]);
      ++count;
    }
    all.push_back(count > 0 ? 255 * sum / count : 0);
  }
  return all;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(std::max<size_t>(values.size(), 1));
}

/// How one pose fits the held-out scenes.
struct Fit {
  double strength = 0;
  int better = 0;  // scenes with a larger strength than with the stated pose
  calibration::ExtrinsicComparison comparison;
};

Fit fit(const std::vector<Scene>& graded, const std::vector<Scene>& edges,
        std::span<const calibration::RigCamera> cameras, const Eigen::Isometry3d& stated,
        const Eigen::Isometry3d& T) {
  const std::array poses{stated, T};
  const std::vector<double> before = edge_strengths(edges, cameras, poses, 0);
  const std::vector<double> with = edge_strengths(edges, cameras, poses, 1);
  Fit out{.strength = mean(with) / std::max(mean(before), 1e-12),
          .better = 0,
          .comparison = calibration::compare_extrinsics(graded, cameras, stated, T, {})};
  for (size_t s = 0; s < with.size(); ++s) out.better += with[s] > before[s] ? 1 : 0;
  return out;
}

}  // namespace

Result<void> study_offset(std::ostream& out, const std::string& drive, const std::string& camera) {
  daemon::SceneRequest request{.drives = {drive}, .max_scenes = 1000};
  if (!camera.empty()) request.cameras = {camera};
  const auto pairs = daemon::read_scene_pairs(request, [](double) {});
  if (!pairs) return tl::unexpected(pairs.error());
  const Eigen::Isometry3d stated =
      pairs->truth ? *pairs->truth : pairs->cameras.front().T_camera_lidar;
  const auto cameras = daemon::rig_cameras(*pairs);
  const auto graded = daemon::make_scenes(*pairs, calibration::named_measures().front(), stated);
  if (!graded) return tl::unexpected(graded.error());
  std::vector<Scene> edges;
  calibration::SceneOptions options{
      .rings = features::ring_directions(cameras.front().model, stated), .equalize = false};
  options.image = {};
  options.image[calibration::index(ImageFeature::kEdge)] = true;
  for (const auto& pair : pairs->pairs) {
    auto scene = calibration::make_scene(pair.sweep, pair.frame, options);
    if (!scene) return tl::unexpected(scene.error());
    edges.push_back(std::move(*scene));
  }
  for (const size_t half : {size_t{0}, size_t{1}}) {
    std::vector<Scene> own, others, other_edges;
    for (size_t s = 0; s < graded->size(); ++s) {
      (s % 2 == half ? own : others).push_back((*graded)[s]);
      if (s % 2 != half) other_edges.push_back(edges[s]);
    }
    const auto result = calibration::calibrate(own, cameras, stated, {});
    const Eigen::Isometry3d& ours = result.T_refcam_lidar;
    const geometry::Vector6 xi = geometry::log(ours * stated.inverse());
    out << "half " << half + 1 << ", " << own.size() << " images"
        << (result.usable() ? "" : ", not usable: " + result.reason)
        << "\n  from the stated pose: ";
    for (int k = 0; k < 6; ++k) out << (k < 3 ? xi(k) / kDegree : 100 * xi(k)) << ' ';
    out << "(deg, cm; camera axes)\n  pose,strength ratio,scenes better,edge rank,dependence,p\n";
    const auto row = [&](const std::string& name, const Eigen::Isometry3d& T) {
      const Fit found = fit(others, other_edges, cameras, stated, T);
      out << "  " << name << ',' << found.strength << ',' << found.better << " of " << others.size()
          << ',' << found.comparison.mean_b.edge_gradient << ','
          << found.comparison.mean_b.dependence << ',' << found.comparison.p_value << "\n"
          << std::flush;
    };
    for (const double share : {-1.0, 0.0, 0.5, 1.0, 1.5, 2.0}) {
      row("from stated to ours " + std::to_string(share), geometry::exp(share * xi) * stated);
    }
    for (const double across : {-0.06, -0.04, -0.02, 0.02, 0.04, 0.06}) {
      geometry::Vector6 shift = geometry::Vector6::Zero();
      shift(3) = across;
      row("ours, across " + std::to_string(across), geometry::exp(shift) * ours);
      row("stated, across " + std::to_string(across), geometry::exp(shift) * stated);
    }
  }
  return {};
}

}  // namespace infuse::study

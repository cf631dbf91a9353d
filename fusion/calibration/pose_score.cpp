#include "fusion/calibration/pose_score.hpp"

#include <utility>

namespace infuse::calibration {
namespace {

/// Assigns to each scene another one of the same camera, half the list away; nothing if a camera
/// has too few images.
std::optional<std::vector<size_t>> other_scene_indices(std::span<const Scene> scenes,
                                                       size_t cameras) {
  std::vector<size_t> other(scenes.size());
  for (size_t camera = 0; camera < cameras; ++camera) {
    std::vector<size_t> own;
    for (size_t s = 0; s < scenes.size(); ++s) {
      if (scenes[s].camera == camera) own.push_back(s);
    }
    if (own.empty()) continue;
    if (own.size() < PoseScore::kMinImages) return std::nullopt;
    for (size_t k = 0; k < own.size(); ++k) {
      other[own[k]] = own[(k + own.size() / 2) % own.size()];
    }
  }
  return other;
}

}  // namespace

PoseScore::PoseScore(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                     std::span<const TermOptions> terms, const VisibilityOptions& visibility,
                     ImagePyramid& images, double sigma, bool subtract_baseline,
                     std::stop_token stop)
    : scenes_(scenes),
      cameras_(cameras),
      terms_(terms),
      visibility_(visibility),
      images_(images.at(ImageBlur::in_angle(sigma))),
      stop_(std::move(stop)) {
  visibility_.max_points = 0;
  if (!subtract_baseline) return;
  if (const auto others = other_scene_indices(scenes, cameras.size()))
    baseline_images_ = images_.permuted(*others);
}

double PoseScore::operator()(const Eigen::Isometry3d& T_refcam_lidar) {
  if (stop_.stop_requested()) return 0;
  const VisiblePoints points = select_visible(scenes_, cameras_, T_refcam_lidar, visibility_);
  if (points.size() == 0) return 0;
  Objective measure(points, images_, cameras_, scenes_, terms_);
  const dependence::Estimate own = measure.evaluate(T_refcam_lidar, false).estimate;
  double value = own.usable() ? own.value : 0;
  if (baseline_images_) {
    measure.set_images(*baseline_images_);
    const dependence::Estimate shared = measure.evaluate(T_refcam_lidar, false).estimate;
    value -= shared.usable() ? shared.value : 0;
  }
  evaluations_ += measure.evaluations();
  return static_cast<double>(points.size()) * value;
}

}  // namespace infuse::calibration

#include "fusion/calibration/any_heading.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace infuse::calibration {
namespace {

constexpr double kSameRotation = 1 * kDegree;

/// The pose with another rotation about the camera's own centre.
Eigen::Isometry3d with_rotation(const Eigen::Isometry3d& T_camera_lidar,
                                const Eigen::Matrix3d& rotation) {
  const Eigen::Vector3d centre = T_camera_lidar.inverse().translation();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotation;
  T.translation() = -rotation * centre;
  return T;
}

/// Options of a calibration that finds the basin and how far lidar and images depend there.
CalibrateOptions coarse_only(CalibrateOptions options, double half_width) {
  options.screen.half_width = half_width;
  options.restarts = options.fine_restarts = options.splits = 0;
  options.check_intrinsics = false;
  options.fine = {quick_level(options)};
  return options;
}

struct Heading {
  Eigen::Isometry3d T_refcam_lidar;
  double value = 0;
};

/// The basins of all headings, the largest dependence first.
std::vector<Heading> find_basins(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                                 const Eigen::Isometry3d& T_initial,
                                 const CalibrateOptions& options, int headings, int& evaluations) {
  std::vector<Heading> found;
  for (int k = 0; k < headings && !options.maximize.stop.stop_requested(); ++k) {
    const Eigen::AngleAxisd turn(2 * std::numbers::pi * k / headings, Eigen::Vector3d::UnitZ());
    const CalibrationResult tried =
        calibrate(scenes, cameras,
                  with_rotation(T_initial, T_initial.linear() * turn.toRotationMatrix()), options);
    evaluations += tried.evaluations;
    if (tried.has_pose) found.push_back({tried.T_refcam_lidar, tried.value});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Heading& a, const Heading& b) { return a.value > b.value; });
  return found;
}

}  // namespace

std::optional<std::string> HeadingOptions::invalid() const {
  if (headings < 2 || headings > 360) return "headings must be between 2 and 360";
  if (!(half_width >= std::numbers::pi / headings && half_width <= std::numbers::pi / 4)) {
    return "half_width must reach the next heading, and be at most 45 degrees";
  }
  if (verified < 1) return "verified must be at least 1";
  if (!(min_share >= 0 && min_share <= 1)) return "min_share must be between 0 and 1";
  if (!(position_sigma > 0)) return "position_sigma must be positive";
  return std::nullopt;
}

CalibrationResult calibrate_any_heading(std::span<const Scene> scenes,
                                        std::span<const RigCamera> cameras,
                                        const Eigen::Isometry3d& T_refcam_lidar_initial,
                                        const CalibrateOptions& options,
                                        const HeadingOptions& headings) {
  CalibrateOptions near = options;
  near.initial_translation_sigma =
      std::max(options.initial_translation_sigma, headings.position_sigma);
  near.screen = {};
  int evaluations = 0;
  const std::vector<Heading> basins =
      find_basins(scenes, cameras, T_refcam_lidar_initial, coarse_only(near, headings.half_width),
                  headings.headings, evaluations);
  CalibrationResult best;
  best.T_refcam_lidar = T_refcam_lidar_initial;
  best.scenes.resize(scenes.size());
  best.reason = "lidar and images cannot be compared at any heading";
  for (size_t k = 0; k < std::min(headings.verified, basins.size()); ++k) {
    if (k > 0 && basins[k].value < headings.min_share * basins.front().value) break;
    CalibrationResult result =
        calibrate(scenes, cameras,
                  with_rotation(T_refcam_lidar_initial, basins[k].T_refcam_lidar.linear()), near);
    evaluations += result.evaluations;
    const Eigen::Matrix3d apart =
        result.T_refcam_lidar.linear() * best.T_refcam_lidar.linear().transpose();
    if (best.usable() && result.usable() && Eigen::AngleAxisd(apart).angle() > kSameRotation) {
      best.reason = "lidar and images fit at two headings";
      break;
    }
    if (k == 0 || (result.usable() && !best.usable())) best = std::move(result);
  }
  best.evaluations = evaluations;
  return best;
}

}  // namespace infuse::calibration

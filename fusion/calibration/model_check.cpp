#include "fusion/calibration/model_check.hpp"

#include <algorithm>
#include <cmath>

namespace infuse::calibration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr double kMinScenesOfModel = 10;    // effective number of scenes
constexpr double kSignificantSigmas = 3.5;  // one in 2000 of a Gaussian
constexpr double kSeriousSigmas = 2 * kSignificantSigmas;
// Share of a parameter's information below which the pose explains all of it, as it does a time
// where the motion is always the same. What is left is rounding.
constexpr double kMinRemainingInformation = 1e-6;

/// Intrinsic parameter of a camera.
struct Intrinsic {
  const char* name;
  const char* unit;
  double display_scale;  // displayed units per unit of the derivative
  double tolerance;      // error that a good calibration of the camera leaves, in `unit`
};

constexpr Intrinsic kIntrinsics[] = {{"focal length", "%", 100, 0.3},
                                     {"principal point cx", "px", 1, 3},
                                     {"principal point cy", "px", 1, 3},
                                     {"radial distortion k1", "", 1, 0.01}};
constexpr double kTimeTolerance = 5;  // ms

/// A further parameter: the scenes' gradients by it, and its information with the pose's and alone.
struct ParameterScore {
  std::vector<double> scene_scores;
  Vector6 pose_coupling = Vector6::Zero();
  double information = 0;
  // Information with the measure's own displacements; empty: they move the pose of all scenes
  // alike, which is no sign of the parameter.
  Eigen::RowVectorXd bias;
};

/// Information of all scenes about the pose.
struct PoseInformation {
  Matrix6 inverse;
  double curvature_share;  // curvature of the objective for one unit of information
};

PoseInformation pose_information(const Uncertainty& uncertainty) {
  const Matrix6 inverse =
      total_information(uncertainty.scene_information).topLeftCorner<6, 6>().inverse();
  return {inverse, (inverse * uncertainty.curvature).trace() / 6};
}

/// Estimated error of a further parameter and its standard deviation, from the scenes' spread and
/// the measure's own bias.
struct ScoredError {
  double value = 0, sigma = 0;
};

ScoredError estimate_error(const ParameterScore& further, const Vector6& weight,
                           double remaining_curvature, double bias_sigma,
                           const Uncertainty& uncertainty) {
  std::vector<double> scores;
  double sum = 0;
  for (size_t s = 0; s < uncertainty.scene_gradients.size(); ++s) {
    const Vector6 by_pose = uncertainty.scene_gradients[s].head<6>();
    if (by_pose == Vector6::Zero()) continue;
    scores.push_back(further.scene_scores[s] - weight.dot(by_pose));
    sum += scores.back();
  }
  const auto n = static_cast<double>(scores.size());
  double squares = 0;
  for (const double score : scores) squares += (score - sum / n) * (score - sum / n);
  // Scenes that are alike have like scores.
  const double scatter = std::sqrt(uncertainty.design_effect * n / (n - 7) * squares);
  return {sum / remaining_curvature, std::hypot(scatter / remaining_curvature, bias_sigma)};
}

/// Standard deviation of a parameter's estimate by the measure's own bias.
double sigma_by_bias(const ParameterScore& further, const Vector6& weight, double remaining,
                     const Uncertainty& uncertainty) {
  if (further.bias.size() == 0) return 0;
  const Eigen::RowVectorXd left =
      further.bias - weight.transpose() * uncertainty.bias_information.topRows<6>();
  return kBiasSigma * left.norm() / remaining;
}

ParameterScore score_intrinsic(std::span<const Scene> scenes, size_t camera, size_t which,
                               const Uncertainty& uncertainty) {
  const auto row = static_cast<Eigen::Index>(6 + which);
  ParameterScore out;
  for (size_t s = 0; s < scenes.size(); ++s) {
    const bool own = scenes[s].camera == camera;
    out.scene_scores.push_back(own ? uncertainty.scene_gradients[s](row) : 0.0);
    if (!own) continue;
    out.pose_coupling += uncertainty.scene_information[s].col(row).head<6>();
    out.information += uncertainty.scene_information[s](row, row);
  }
  const Eigen::Index columns = 2 * kDepthBands;
  const auto first = static_cast<Eigen::Index>(camera) * columns;
  out.bias = Eigen::RowVectorXd::Zero(uncertainty.bias_information.cols());
  out.bias.segment(first, columns) = uncertainty.bias_information.row(row).segment(first, columns);
  return out;
}

/// An image taken dt later sees p from exp(ξ dt) further on: T exp(−ξ dt) p.
ParameterScore score_delay(const Eigen::Isometry3d& T, std::span<const Scene> scenes,
                           const Uncertainty& uncertainty) {
  const Matrix6 adjoint = geometry::adjoint(T);
  ParameterScore out;
  for (size_t s = 0; s < scenes.size(); ++s) {
    const Vector6 moves = -adjoint * *scenes[s].twist;
    out.scene_scores.push_back(moves.dot(uncertainty.scene_gradients[s].head<6>()));
    const Vector6 coupling = uncertainty.scene_information[s].topLeftCorner<6, 6>() * moves;
    out.pose_coupling += coupling;
    out.information += moves.dot(coupling);
  }
  return out;
}

}  // namespace

std::optional<std::string> KnownParameters::invalid() const {
  if (!(focal_sigma >= 0 && focal_sigma <= 0.1)) return "focal_sigma must be between 0 and 0.1";
  if (!(principal_point_sigma >= 0 && principal_point_sigma <= 100)) {
    return "principal_point_sigma must be between 0 and 100 px";
  }
  if (!(radial_sigma >= 0 && radial_sigma <= 1)) return "radial_sigma must be between 0 and 1";
  if (time_sigma < Duration{0} || time_sigma > Duration{100'000'000}) {
    return "time_sigma must be between 0 and 100 ms";
  }
  return std::nullopt;
}

ParameterCheck make_intrinsic_check(size_t intrinsic, double error, size_t camera, size_t cameras) {
  const Intrinsic& of = kIntrinsics[intrinsic];
  return {.parameter =
              std::string(of.name) + (cameras > 1 ? " of camera " + std::to_string(camera) : ""),
          .unit = of.unit,
          .value = of.display_scale * error};
}

std::vector<ParameterCheck> check_model(const Eigen::Isometry3d& T_refcam_lidar, size_t cameras,
                                        std::span<const Scene> scenes,
                                        const Uncertainty& uncertainty,
                                        const KnownParameters& known) {
  std::vector<ParameterCheck> checks;
  if (!uncertainty.usable()) return checks;
  const bool enough = uncertainty.effective_scenes >= kMinScenesOfModel;
  const double known_sigmas[] = {known.focal_sigma, known.principal_point_sigma,
                                 known.principal_point_sigma, known.radial_sigma};
  const PoseInformation pose = pose_information(uncertainty);
  const auto add = [&](const ParameterScore& further, ParameterCheck check, double display_scale,
                       double tolerance, double known_sigma) {
    const Vector6 weight = pose.inverse * further.pose_coupling;
    const double remaining = further.information - further.pose_coupling.dot(weight);
    const double curvature = pose.curvature_share * remaining;
    check.pose_sensitivity = -weight / display_scale;
    check.known_sigma = display_scale * known_sigma;
    check.tolerance = tolerance;
    if (enough && remaining > kMinRemainingInformation * further.information) {
      const double by_bias = sigma_by_bias(further, weight, remaining, uncertainty);
      const ScoredError error = estimate_error(further, weight, curvature, by_bias, uncertainty);
      check.value = display_scale * error.value;
      check.sigma = display_scale * error.sigma;
      check.significance = check.value / std::hypot(check.sigma, check.known_sigma);
    }
    const bool exceeds_tolerance = std::abs(check.value) > tolerance;
    check.significant = exceeds_tolerance && std::abs(check.significance) > kSignificantSigmas;
    check.serious = exceeds_tolerance && std::abs(check.significance) > kSeriousSigmas;
    checks.push_back(check);
  };
  for (size_t c = 0; c < cameras; ++c) {
    for (size_t which = 0; which < std::size(kIntrinsics); ++which) {
      const Intrinsic& of = kIntrinsics[which];
      add(score_intrinsic(scenes, c, which, uncertainty),
          make_intrinsic_check(which, 0, c, cameras), of.display_scale, of.tolerance,
          known_sigmas[which]);
    }
  }
  const bool moving = std::all_of(scenes.begin(), scenes.end(),
                                  [](const Scene& scene) { return scene.twist.has_value(); });
  if (moving) {
    add(score_delay(T_refcam_lidar, scenes, uncertainty),
        {.parameter = "image time offset", .unit = "ms"}, 1e3, kTimeTolerance,
        to_seconds(known.time_sigma));
  }
  return checks;
}

Matrix6 model_covariance(std::span<const ParameterCheck> parameters, const Matrix6& scenes) {
  Matrix6 sum = Matrix6::Zero();
  double squares = 0;
  for (const ParameterCheck& one : parameters) {
    const Vector6 moved = std::hypot(one.known_sigma, one.unseen_sigma) * one.pose_sensitivity;
    sum += moved * moved.transpose();
    const double sigma = std::hypot(one.sigma, one.known_sigma, one.tolerance);
    squares += sigma > 0 ? one.value * one.value / (sigma * sigma) : 0;
  }
  const auto tests = static_cast<double>(parameters.size());
  return squares > tests ? sum + (squares / tests - 1) * scenes : sum;
}

}  // namespace infuse::calibration

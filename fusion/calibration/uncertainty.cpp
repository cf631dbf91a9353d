#include "fusion/calibration/uncertainty.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/distributions.hpp"
#include "fusion/calibration/scene_similarity.hpp"
#include "fusion/geometry/symmetric_eigen.hpp"

namespace infuse::calibration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

// Steps of numeric differences: about the standard deviation of the result, from
// `kCurvatureStep` to so many times it; halves of it where it leads to no maximum, as with long
// focal lengths. Smaller steps measure how rings cross image edges instead of the shape of the
// maximum, larger ones its flanks.
constexpr double kMaxStepGrowth = 4;
constexpr double kMinStepGrowth = 1 / kMaxStepGrowth;  // decision 21
// Steps along directions of little information are longer than the others, up to so many times.
constexpr double kMaxStepRatio = kMaxStepGrowth;
constexpr double kMaxRotationSigma = 5 * kDegree;
constexpr double kMaxTranslationSigma = 0.5;

/// Returns "rotation about (1.0, 0.0, 0.0)" or "translation along …", in camera axes.
std::string describe_direction(const Vector6& scaled) {
  const bool rotation = scaled.head<3>().norm() > scaled.tail<3>().norm();
  Eigen::Vector3d axis = rotation ? scaled.head<3>() : scaled.tail<3>();
  axis.normalize();
  char text[96];
  std::snprintf(text, sizeof text, "%s (%.1f, %.1f, %.1f)",
                rotation ? "rotation about" : "translation along", axis.x(), axis.y(), axis.z());
  return text;
}

/// Scales a covariance by the limits: the maximum accepted standard deviation of a direction is 1.
Vector6 sigma_limits() {
  Vector6 unit;
  unit << Eigen::Vector3d::Constant(kMaxRotationSigma),
      Eigen::Vector3d::Constant(kMaxTranslationSigma);
  return unit;
}

/// Σ_s g_s g_sᵀ of the scene gradients less their mean.
Matrix6 gradient_scatter(const std::vector<Vector6>& pulls) {
  const auto n = static_cast<double>(pulls.size());
  const Vector6 mean = std::accumulate(pulls.begin(), pulls.end(), Vector6::Zero().eval()) / n;
  Matrix6 scatter = Matrix6::Zero();
  for (const Vector6& pull : pulls) scatter += (pull - mean) * (pull - mean).transpose();
  return scatter;
}

/// H⁻¹ J H⁻¹, or why it does not exist.
struct Sandwich {
  Matrix6 covariance = Matrix6::Zero();
  std::string reason;
};

Sandwich sandwich(const Matrix6& curvature, const Matrix6& scatter, double effective) {
  const Vector6 unit = sigma_limits();
  const auto eigen =
      geometry::symmetric_eigen<6>(unit.asDiagonal() * curvature * unit.asDiagonal());
  const double largest = eigen.values[5];
  if (!(eigen.values[0] > 1e-6 * largest) || !(largest > 0)) {
    return {.reason = "not observable: " + describe_direction(eigen.vectors.col(0)) +
                      " in camera axes is free"};
  }
  const Matrix6 inverse = curvature.inverse();
  const double scale = (inverse * scatter).trace() / 6;
  const double shrinkage = kShrinkageScenes / (kShrinkageScenes + effective - 1);
  const Matrix6 shrunk = (1 - shrinkage) * scatter + shrinkage * scale * curvature;
  const Matrix6 covariance =
      widening_of_few(2 * (effective - 1)) * inverse * shrunk * inverse.transpose();
  return {.covariance = 0.5 * (covariance + covariance.transpose())};
}

/// Largest standard deviation of an axis, as an angle.
double max_angular_sigma(const Matrix6& covariance, double range) {
  const Vector6 sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  return std::max(sigma.head<3>().maxCoeff(), sigma.tail<3>().maxCoeff() / range);
}

}  // namespace

Matrix6 pose_curvature(Objective& objective, const Eigen::Isometry3d& T, const Matrix6& steps) {
  Matrix6 differences;
  for (int k = 0; k < 6; ++k) {
    const Vector6 xi = steps.col(k);
    differences.col(k) = 0.5 * (objective.evaluate(geometry::exp(-xi) * T, true).gradient -
                                objective.evaluate(geometry::exp(xi) * T, true).gradient);
  }
  const Matrix6 in_steps = steps.transpose() * differences;
  const Matrix6 inverse = steps.inverse();
  return inverse.transpose() * (0.5 * (in_steps + in_steps.transpose())) * inverse;
}

Matrix6 curvature_steps(const Matrix6& information, double range) {
  Vector6 unit;
  unit << Eigen::Vector3d::Ones(), Eigen::Vector3d::Constant(range);
  const auto eigen =
      geometry::symmetric_eigen<6>(unit.asDiagonal() * information * unit.asDiagonal());
  const double mean = eigen.values.mean();
  Matrix6 steps;
  for (int k = 0; k < 6; ++k) {
    const double even = eigen.values[k] > 0 ? std::sqrt(mean / eigen.values[k]) : kMaxStepRatio;
    steps.col(k) = std::min(even, kMaxStepRatio) * unit.cwiseProduct(eigen.vectors.col(k));
  }
  return steps;
}

std::string describe_imprecision(const Matrix6& covariance, double max_rotation_sigma,
                                 double max_translation_sigma) {
  if (!covariance.allFinite()) return "the covariance is not finite";
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> rotation(covariance.topLeftCorner<3, 3>());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> translation(
      covariance.bottomRightCorner<3, 3>());
  const double rotation_sigma = std::sqrt(std::max(0.0, rotation.eigenvalues()(2)));
  const double translation_sigma = std::sqrt(std::max(0.0, translation.eigenvalues()(2)));
  const bool turned =
      rotation_sigma / max_rotation_sigma > translation_sigma / max_translation_sigma;
  if (rotation_sigma <= max_rotation_sigma && translation_sigma <= max_translation_sigma) return {};
  Vector6 direction = Vector6::Zero();
  if (turned) {
    direction.head<3>() = rotation.eigenvectors().col(2);
  } else {
    direction.tail<3>() = translation.eigenvectors().col(2);
  }
  char text[160];
  std::snprintf(
      text, sizeof text, "the standard deviation of %s in camera axes is %.2g %s (allowed: %.2g)",
      describe_direction(direction).c_str(),
      turned ? rotation_sigma / kDegree : 100 * translation_sigma, turned ? "degrees" : "cm",
      turned ? max_rotation_sigma / kDegree : 100 * max_translation_sigma);
  return text;
}

double scatter_factor(double design_effect, size_t scenes) {
  const auto n = static_cast<double>(scenes);
  return design_effect * n / (n - design_effect);
}

namespace {

/// The gradients of the scenes that have points in view; writes how many scenes they count as.
std::vector<Vector6> count_scenes(const Eigen::MatrixXd& similarity, Uncertainty& out) {
  std::vector<Vector6> seen;
  std::vector<Eigen::Index> seen_scenes;
  for (size_t s = 0; s < out.scene_gradients.size(); ++s) {
    if (out.scene_gradients[s].head<6>() == Vector6::Zero()) continue;
    seen.push_back(out.scene_gradients[s].head<6>());
    seen_scenes.push_back(static_cast<Eigen::Index>(s));
  }
  out.effective_scenes = static_cast<double>(seen.size());
  if (similarity.size() > 0) {
    const Eigen::MatrixXd seen_similarity = similarity(seen_scenes, seen_scenes);
    const Eigen::VectorXd weights = scene_weights(similarity)(seen_scenes);
    out.effective_scenes = effective_scenes(seen_similarity, weights);
    out.design_effect = design_effect(seen_similarity, weights);
  }
  return seen;
}

/// Why these scenes do not show how far scenes disagree, or nothing.
std::string describe_few_scenes(size_t seen, double effective) {
  if (seen < 3) {
    return std::to_string(seen) +
           " scenes do not show how far scenes disagree: at least 3 are needed";
  }
  if (effective >= kMinEffectiveScenes) return {};
  char text[160];
  std::snprintf(text, sizeof text,
                "%zu scenes of nearly the same place count as %.1f: at least 3 are needed; "
                "record at other places",
                seen, effective);
  return text;
}

/// Tries steps until they are about as long as the standard deviation; writes the curvature.
Sandwich find_sandwich(Objective& objective, const Eigen::Isometry3d& T, const Matrix6& scatter,
                       const Matrix6& information, Uncertainty& out) {
  const double range = objective.median_range();
  const Matrix6 steps = curvature_steps(information, range);
  Sandwich found{.reason = "not evaluated"};
  const auto try_step = [&](double angle) {
    const Matrix6 H = pose_curvature(objective, T, angle * steps);
    const Sandwich next = sandwich(H, scatter, out.effective_scenes);
    if (!next.reason.empty() && found.reason.empty()) return;
    found = next;
    out.curvature = H;
  };
  try_step(kCurvatureStep);
  for (double angle = kCurvatureStep / 2;
       !found.reason.empty() && angle >= kMinStepGrowth * kCurvatureStep; angle /= 2) {
    try_step(angle);
  }
  const auto is_too_small = [&](double angle) {
    return !found.reason.empty() || max_angular_sigma(found.covariance, range) > 2 * angle;
  };
  for (double angle = kCurvatureStep;
       angle < kMaxStepGrowth * kCurvatureStep && is_too_small(angle); angle *= 2) {
    try_step(2 * angle);
  }
  return found;
}

/// Which direction is not known well enough for the covariance to mean anything, or nothing.
std::string describe_unknown_direction(const Matrix6& covariance) {
  const Vector6 unit = sigma_limits();
  const Matrix6 scaled =
      unit.cwiseInverse().asDiagonal() * covariance * unit.cwiseInverse().asDiagonal();
  const auto worst = geometry::symmetric_eigen<6>(scaled);
  if (!(worst.values[5] > 1)) return {};
  return "not observable: " + describe_direction(worst.vectors.col(5)) +
         " in camera axes is known to worse than 5 degrees or 50 cm";
}

}  // namespace

Uncertainty estimate_uncertainty(Objective& objective, const Eigen::Isometry3d& T_refcam_lidar,
                                 const Eigen::MatrixXd& similarity) {
  Uncertainty out;
  out.scene_gradients = objective.scene_gradients(T_refcam_lidar);
  out.scene_influence.assign(out.scene_gradients.size(), 0.0);
  const std::vector<Vector6> seen = count_scenes(similarity, out);
  out.reason = describe_few_scenes(seen.size(), out.effective_scenes);
  if (!out.usable()) return out;
  const Matrix6 scatter = scatter_factor(out.design_effect, seen.size()) * gradient_scatter(seen);
  PointInformation points = objective.information(T_refcam_lidar);
  out.scene_information = std::move(points.scenes);
  out.bias_information = std::move(points.bias);
  const Matrix6 information_of_points =
      total_information(out.scene_information).topLeftCorner<6, 6>();
  const Sandwich found =
      find_sandwich(objective, T_refcam_lidar, scatter, information_of_points, out);
  out.reason = found.reason;
  if (!out.usable()) return out;
  out.cramer_rao_bound = information_of_points.inverse();
  const Eigen::Matrix<double, 6, Eigen::Dynamic> moved_by =
      kBiasSigma * out.cramer_rao_bound * out.bias_information.topRows<6>();
  out.bias_covariance = moved_by * moved_by.transpose();
  out.covariance = found.covariance + out.bias_covariance;
  out.reason = describe_unknown_direction(out.covariance);
  const Matrix6 inverse = out.curvature.inverse();
  const Matrix6 information = out.covariance.inverse();
  for (size_t s = 0; s < out.scene_gradients.size(); ++s) {
    const Vector6 moved = inverse * out.scene_gradients[s].head<6>();
    out.scene_influence[s] = std::sqrt(std::max(0.0, moved.dot(information * moved)));
  }
  return out;
}

}  // namespace infuse::calibration

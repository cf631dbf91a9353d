#include "fusion/calibration/uncertainty.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace infuse::calibration {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

// Of the differences: as wide as the result is uncertain on a few scenes. What is rougher than that
// are the rings of the lidar crossing the picture's edges, not the shape of the maximum.
constexpr double kRotationStep = 1e-3;     // rad
constexpr double kTranslationStep = 0.01;  // m
constexpr double kRotationLimit = 5 * M_PI / 180;
constexpr double kTranslationLimit = 0.5;

Matrix6 curvature(Objective& objective, const Eigen::Isometry3d& T) {
  Matrix6 H;
  for (int k = 0; k < 6; ++k) {
    const double step = k < 3 ? kRotationStep : kTranslationStep;
    const Vector6 xi = step * Vector6::Unit(k);
    const Vector6 after = objective.evaluate(geometry::exp(xi) * T, true).gradient;
    const Vector6 before = objective.evaluate(geometry::exp(-xi) * T, true).gradient;
    H.col(k) = (before - after) / (2 * step);
  }
  return 0.5 * (H + H.transpose());
}

/// "rotation about (1.0, 0.0, 0.0)" or "translation along …", in camera axes.
std::string name_direction(const Vector6& scaled) {
  const bool rotation = scaled.head<3>().norm() > scaled.tail<3>().norm();
  Eigen::Vector3d axis = rotation ? scaled.head<3>() : scaled.tail<3>();
  axis.normalize();
  char text[96];
  std::snprintf(text, sizeof text, "%s (%.1f, %.1f, %.1f)",
                rotation ? "rotation about" : "translation along", axis.x(), axis.y(), axis.z());
  return text;
}

}  // namespace

Uncertainty estimate_uncertainty(Objective& objective, const Eigen::Isometry3d& T_head_lidar) {
  Uncertainty out;
  out.curvature = curvature(objective, T_head_lidar);
  const std::vector<Vector6> pulls = objective.scene_gradients(T_head_lidar);
  std::vector<Vector6> seen;
  for (const Vector6& pull : pulls) {
    if (pull != Vector6::Zero()) seen.push_back(pull);
  }
  out.pull.assign(pulls.size(), 0.0);
  const auto scenes = static_cast<double>(seen.size());
  if (seen.size() < 3) {
    out.reason = std::to_string(seen.size()) +
                 " scenes say nothing of how far scenes disagree: at least 3 are needed";
    return out;
  }

  // In units of the limits: a direction's standard deviation of 1 is the most that is accepted.
  Vector6 unit;
  unit << Eigen::Vector3d::Constant(kRotationLimit), Eigen::Vector3d::Constant(kTranslationLimit);
  const Matrix6 H = unit.asDiagonal() * out.curvature * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(H);
  const double largest = eigen.eigenvalues()(5);
  if (!(eigen.eigenvalues()(0) > 1e-6 * largest) || !(largest > 0)) {
    out.reason = "not observable: " + name_direction(eigen.eigenvectors().col(0)) +
                 " in camera axes is free";
    return out;
  }
  Matrix6 spread = Matrix6::Zero();
  const Vector6 mean = std::accumulate(seen.begin(), seen.end(), Vector6::Zero().eval()) / scenes;
  for (const Vector6& pull : seen) spread += (pull - mean) * (pull - mean).transpose();
  spread *= scenes / std::max(scenes - 6, 1.0);
  const Matrix6 inverse = out.curvature.inverse();
  out.covariance = inverse * spread * inverse.transpose();
  out.covariance = 0.5 * (out.covariance + out.covariance.transpose()).eval();

  out.bound = objective.information(T_head_lidar).inverse();
  const Matrix6 scaled =
      unit.cwiseInverse().asDiagonal() * out.covariance * unit.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> worst(scaled);
  if (worst.eigenvalues()(5) > 1) {
    out.reason = "not observable: " + name_direction(worst.eigenvectors().col(5)) +
                 " in camera axes is known to worse than 5 degrees or 50 cm";
  }
  const Matrix6 information = out.covariance.inverse();
  for (size_t s = 0; s < pulls.size(); ++s) {
    const Vector6 moved = inverse * pulls[s];
    out.pull[s] = std::sqrt(std::max(0.0, moved.dot(information * moved)));
  }
  return out;
}

}  // namespace infuse::calibration

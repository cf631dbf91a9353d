#include "fusion/target/solve_target.hpp"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "fusion/geometry/plane_length.hpp"
#include "fusion/target/degeneracy.hpp"
#include "fusion/target/pose_parameter.hpp"
#include "fusion/target/view_consensus.hpp"
#include "fusion/target/view_residuals.hpp"

namespace infuse::target {
namespace {

using geometry::Matrix6;

constexpr int kMaxRounds = 10;      // maximum number of outlier rejections
constexpr double kCauchyScale = 4;  // standard deviations, scale of the Cauchy loss of the first
                                    // round
constexpr double kEpsilon = 1e-12;  // m²; lower bound of a residual's variance (1 µm)

/// Views, the points that represent their returns, and the inlier flags.
struct ViewSet {
  std::span<const TargetView> views;
  std::vector<ReturnsPlane> planes;
  std::vector<ViewResidual> residuals;
  double range_noise;

  std::vector<const TargetView*> used_views() const {
    std::vector<const TargetView*> used;
    for (size_t i = 0; i < views.size(); ++i) {
      if (residuals[i].used) used.push_back(&views[i]);
    }
    return used;
  }

  Eigen::Matrix4d covariance(size_t i, const Eigen::Isometry3d& T) const {
    return residual_covariance(views[i], planes[i], T, range_noise) +
           kEpsilon * Eigen::Matrix4d::Identity();
  }
};

/// Cost of one view in P(3.10), with whitened residuals W r, where Wᵀ W is the inverse of their
/// covariance at the initial pose.
class ViewCost : public ceres::SizedCostFunction<4, 6> {
 public:
  ViewCost(const PoseParameter& pose, const TargetView& view, const ReturnsPlane& plane,
           const Eigen::Matrix4d& covariance)
      : pose_(pose),
        view_(view),
        plane_(plane),
        whitening_(covariance.llt().matrixL().solve(Eigen::Matrix4d::Identity())) {}

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override {
    const LinearisedView view = linearise_view(view_, plane_, pose_.at(parameters[0]));
    Eigen::Map<Eigen::Vector4d> out(residuals);
    out = whitening_ * view.residuals;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 4, 6, Eigen::RowMajor>> jacobian(jacobians[0]);
      jacobian = whitening_ * PoseParameter::jacobian_by_xi(view.jacobian, parameters[0]);
    }
    return true;
  }

 private:
  const PoseParameter& pose_;
  const TargetView& view_;
  const ReturnsPlane& plane_;
  Eigen::Matrix4d whitening_;
};

/// Minimises P(3.10) over the inlier views, with a Cauchy loss if `robust`.
Eigen::Isometry3d minimise(const ViewSet& set, const Eigen::Isometry3d& T_initial, bool robust) {
  const PoseParameter pose{T_initial};
  geometry::Vector6 xi = geometry::Vector6::Zero();
  ceres::Problem problem;
  for (size_t i = 0; i < set.views.size(); ++i) {
    if (!set.residuals[i].used) continue;
    problem.AddResidualBlock(
        new ViewCost(pose, set.views[i], set.planes[i], set.covariance(i, T_initial)),
        robust ? new ceres::CauchyLoss(kCauchyScale) : nullptr, xi.data());
  }
  ceres::Solver::Options options;
  options.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary.IsSolutionUsable() ? pose.at(xi.data()) : T_initial;
}

/// Covariance, P(3.12). F is weighted by the covariance of its residuals, which are linear in the
/// measurements, so that the mixed derivatives and Σ_X together equal ∂²F/∂Θ² and one inverse of it
/// remains.
Matrix6 compute_covariance(const ViewSet& set, const Eigen::Isometry3d& T) {
  Matrix6 information = Matrix6::Zero();
  for (size_t i = 0; i < set.views.size(); ++i) {
    if (!set.residuals[i].used) continue;
    const auto J = linearise_view(set.views[i], set.planes[i], T).jacobian;
    information += J.transpose() * set.covariance(i, T).inverse() * J;
  }
  const Matrix6 covariance = information.inverse();
  return 0.5 * (covariance + covariance.transpose());
}

/// Computes the residuals of a view; an outlier view is compared with a solution made without it.
void evaluate_view(const ViewSet& set, size_t i, const Eigen::Isometry3d& T,
                   const Matrix6& solution_covariance, ViewResidual& out) {
  const LinearisedView view = linearise_view(set.views[i], set.planes[i], T);
  Eigen::Matrix4d covariance = set.covariance(i, T);
  if (!out.used) covariance += view.jacobian * solution_covariance * view.jacobian.transpose();
  out.offset = view.residuals.mean();
  out.rms = geometry::plane_length(std::sqrt(view.residuals.squaredNorm() / 4), set.planes[i].rms);
  const double along = set.views[i].normal().dot(T.linear() * set.planes[i].normal);
  out.tilt = std::acos(std::min(1.0, std::abs(along)));
  out.mahalanobis =
      std::sqrt(std::max(0.0, view.residuals.dot(covariance.inverse() * view.residuals)));
}

/// Range standard deviation estimated from the distances of the returns to their own planes.
double estimate_range_noise(const ViewSet& set) {
  double squares = 0;
  double slopes = kEpsilon;
  for (size_t i = 0; i < set.views.size(); ++i) {
    if (!set.residuals[i].used) continue;
    const auto n = static_cast<double>(set.views[i].returns.size());
    const double slope = set.planes[i].normal.dot(set.planes[i].mean.normalized());
    squares += n * set.planes[i].rms * set.planes[i].rms;
    slopes += (n - 3) * slope * slope;
  }
  return std::sqrt(squares / slopes);
}

/// Updates the set of outliers; returns true if it changed.
bool update_outliers(ViewSet& set, const SolveTargetOptions& options) {
  bool changed = false;
  for (ViewResidual& view : set.residuals) {
    const bool inlier = view.mahalanobis <= options.max_mahalanobis ||
                        std::abs(view.offset) + view.tilt <= options.inlier_tolerance;
    changed = changed || inlier != view.used;
    view.used = inlier;
  }
  return changed;
}

void summarise(const ViewSet& set, TargetResult& result) {
  double squares = 0;
  double returns = kEpsilon;
  for (size_t i = 0; i < set.views.size(); ++i) {
    if (!set.residuals[i].used) continue;
    ++result.used;
    const auto n = static_cast<double>(set.views[i].returns.size());
    squares += n * set.residuals[i].rms * set.residuals[i].rms;
    returns += n;
  }
  result.rms = std::sqrt(squares / returns);
  result.range_noise = set.range_noise;
  result.views = set.residuals;
}

}  // namespace

std::optional<std::string> SolveTargetOptions::invalid() const {
  if (!(range_noise > 0)) return "range_noise must be positive";
  if (!(max_mahalanobis > 0)) return "max_mahalanobis must be positive";
  if (!(inlier_tolerance >= 0)) return "inlier_tolerance must not be negative";
  if (!(max_rotation_sigma > 0) || !(max_translation_sigma > 0)) {
    return "max_rotation_sigma and max_translation_sigma must be positive";
  }
  return std::nullopt;
}

TargetResult solve_target(std::span<const TargetView> views, const Eigen::Isometry3d& T_initial,
                          const SolveTargetOptions& options) {
  TargetResult result{.T_refcam_lidar = T_initial};
  ViewSet set{views, {}, std::vector<ViewResidual>(views.size()), options.range_noise};
  for (const TargetView& view : views) set.planes.push_back(fit_returns_plane(view.returns));

  Eigen::Isometry3d& T = result.T_refcam_lidar;
  T = find_consensus_pose(views, set.planes, options.seed).value_or(T_initial);
  for (int round = 0; round < kMaxRounds; ++round) {
    result.reason = describe_degeneracy(set.used_views());
    if (!result.reason.empty()) break;
    set.range_noise = std::max(options.range_noise, estimate_range_noise(set));
    T = minimise(set, T, round == 0);
    result.covariance = compute_covariance(set, T);
    for (size_t i = 0; i < views.size(); ++i) {
      evaluate_view(set, i, T, result.covariance, set.residuals[i]);
    }
    if (!update_outliers(set, options) && round > 0) break;
  }
  summarise(set, result);
  if (!result.reason.empty()) return result;
  if (2 * result.used <= static_cast<int>(views.size())) {
    result.reason = "most views are outliers: " + std::to_string(result.used) + " of " +
                    std::to_string(views.size()) + " agree";
  } else {
    result.reason = describe_uncertain_axis(result.covariance, options.max_rotation_sigma,
                                            options.max_translation_sigma);
  }
  return result;
}

}  // namespace infuse::target

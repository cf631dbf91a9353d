#include "fusion/calibration/maximize.hpp"

#include <limits>

#include "fusion/calibration/ascent.hpp"

namespace infuse::calibration {
namespace {

using geometry::Vector6;

constexpr const char* kNotConverged = "the optimisation did not converge within its iterations";

/// Objective around an initial pose, in scaled coordinates: T(d) = exp(scale ∘ d) T_initial.
class LocalProblem {
 public:
  LocalProblem(Objective& objective, const Eigen::Isometry3d& initial_pose,
               const MaximizeOptions& options)
      : objective_(objective),
        initial_pose_(initial_pose),
        prior_(options.position_prior),
        stop_(options.stop) {
    scale_ << Eigen::Vector3d::Constant(kRotationScale),
        Eigen::Vector3d::Constant(kTranslationScale);
  }

  Eigen::Isometry3d pose(const Vector6& d) const {
    return geometry::exp(scale_.cwiseProduct(d)) * initial_pose_;
  }

  /// Returns the value, and fills in the gradient by d where that is not null: the left Jacobian
  /// converts the derivative by ξ.
  dependence::Estimate evaluate(const Vector6& d, Vector6* gradient) const {
    if (stop_.stop_requested()) {  // no step leads up from here
      if (gradient != nullptr) gradient->setZero();
      return {.value = -std::numeric_limits<double>::infinity(), .reason = kCancelled};
    }
    const Eigen::Isometry3d T = pose(d);
    Evaluation at = objective_.evaluate(T, gradient != nullptr);
    if (prior_.weight > 0) apply_prior(T, at);
    if (gradient != nullptr) {
      const geometry::Matrix6 jacobian = geometry::left_jacobian(scale_.cwiseProduct(d));
      *gradient = (jacobian.transpose() * at.gradient).cwiseProduct(scale_);
    }
    return at.estimate;
  }

 private:
  /// Subtracts the prior's penalty from the value, and its derivative from the gradient.
  void apply_prior(const Eigen::Isometry3d& T, Evaluation& at) const {
    const Eigen::Vector3d off = T.inverse().translation() - prior_.centre;
    at.estimate.value -= 0.5 * prior_.weight * off.squaredNorm();
    // exp(ω, ρ) T moves the camera's origin by −Rᵀρ in the lidar frame, whatever ω is.
    at.gradient.tail<3>() += prior_.weight * (T.linear() * off);
  }

  Objective& objective_;
  Eigen::Isometry3d initial_pose_;
  PositionPrior prior_;
  std::stop_token stop_;
  Vector6 scale_;
};

PoseAscentResult ascend(const PoseFunction& function, const MaximizeOptions& options) {
  AscentOptions ascent{.max_iterations = options.max_iterations, .tolerance = options.tolerance};
  if (options.optimizer == Optimizer::kBfgs) return ascend_bfgs(function, ascent);
  ascent.max_iterations *= 10;
  return ascend_simplex(function, ascent);
}

}  // namespace

std::optional<std::string> MaximizeOptions::invalid() const {
  if (max_iterations < 1) return "max_iterations must be at least 1";
  if (!(tolerance > 0)) return "tolerance must be positive";
  return std::nullopt;
}

Maximum maximize(Objective& objective, const Eigen::Isometry3d& initial_pose,
                 const MaximizeOptions& options) {
  const LocalProblem problem(objective, initial_pose, options);
  Vector6 slope = Vector6::Zero();
  const dependence::Estimate first = problem.evaluate(
      Vector6::Zero(), options.optimizer == Optimizer::kSimplex ? nullptr : &slope);
  Maximum maximum{.T_refcam_lidar = initial_pose, .value = first.value, .reason = first.reason};
  if (!first.usable()) return maximum;
  if (slope.norm() == 0 && options.optimizer != Optimizer::kSimplex) {
    maximum.reason = "the measure does not change with the calibration";
    return maximum;
  }
  const PoseAscentResult ascent = ascend(
      [&](const Vector6& d, Vector6* gradient) { return problem.evaluate(d, gradient).value; },
      options);
  if (ascent.value >= first.value) {
    maximum.T_refcam_lidar = problem.pose(ascent.d);
    maximum.value = ascent.value;
  }
  if (!ascent.converged) maximum.reason = kNotConverged;
  if (options.stop.stop_requested()) maximum.reason = kCancelled;
  return maximum;
}

}  // namespace infuse::calibration

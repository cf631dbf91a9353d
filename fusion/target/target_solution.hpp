#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/target/target_model.hpp"

namespace infuse::target {

/// Standard deviations of the shifts of boards that neither corners nor returns explain.
struct Misfit {
  double offset = 0;  ///< m
  double tilt = 0;    ///< rad, along each side

  /// As covariance of a board's shift.
  ShiftCovariance covariance() const;
};

/// Solution of the views' equations, all linearised at one pose.
struct TargetSolution {
  Eigen::VectorXd shared;               ///< parameters of `TargetModel`, the pose's first
  Eigen::MatrixXd information;          ///< inverse covariance of them
  std::vector<ReducedView> views;       ///< of the used views, their boards' shifts eliminated
  double minus_two_log_likelihood = 0;  ///< restricted; up to a constant

  /// Covariance of the pose.
  geometry::Matrix6 pose_covariance() const;
};

/// Solves the views' equations, given the covariance of each board's shift. `prior` as
/// `TargetModel::prior_information` returns it.
TargetSolution solve_views(std::span<const ViewEquations> views,
                           std::span<const ShiftCovariance> shift_covariances,
                           const Eigen::MatrixXd& prior, double noise);

/// The shift of a view's board that fits its returns best, given the shared parameters.
BoardShift fit_shift(const ViewEquations& view, const Eigen::VectorXd& shared);

/// Squared distances of a view's returns from its board, given all parameters, m².
double remaining_squares(const ViewEquations& view, const Eigen::VectorXd& shared,
                         const BoardShift& shift);

/// Misfit of greatest restricted likelihood (Patterson and Thompson 1971): that by which the boards
/// scatter more than their corners and returns explain.
Misfit estimate_misfit(std::span<const ViewEquations> views,
                       std::span<const ShiftCovariance> corner_covariances,
                       const Eigen::MatrixXd& prior, double noise);

/// Birge ratio of leaving out each view: mean square of the changes of the pose in units of their
/// own covariance, which is that without the view minus that with it. Above 1 the views disagree by
/// more than the covariance states. 0 if no view can be left out.
double leave_one_out_ratio(const TargetSolution& solution);

}  // namespace infuse::target

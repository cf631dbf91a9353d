#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fusion/target/solve_intrinsics.hpp"

namespace infuse::target {

/// How well views determine the intrinsics.
struct IntrinsicsCovariance {
  /// Of the first `intrinsics_count` numbers; empty if the views do not determine them.
  Eigen::MatrixXd covariance;
  double corner_noise = 0;  ///< px; standard deviation per axis, by the residuals
  /// Mean square of the views' scores relative to that of independent corners: 1 if the errors of a
  /// view's corners are independent. The covariance is widened by it where it is above 1.
  double view_ratio = 0;
};

/// Covariance at a solution, the poses and the board's bow eliminated. The noise of the corners is
/// that of the residuals. What the corners of a view share (blur, a hand that moves the board, a
/// lens that is not of the model) does not average out within a view, but between views: each view
/// is a cluster. With the score g_v = A_vᵀ r_v of the eliminated equations A_v, H_v = A_vᵀ A_v and
/// H = Σ H_v, independent corners have E[g_v g_vᵀ] = σ² (H_v − H_v H⁻¹ H_v); the ratio is
/// Σ g_vᵀ H⁻¹ g_v / (σ² tr Σ (H⁻¹ H_v − (H⁻¹ H_v)²)) (Liang and Zeger 1986; Bell and McCaffrey
/// 2002). As V views alone know it, the covariance is widened by (V − 1) / (V − 3), the variance of
/// Student's t. Not determined with three views or fewer.
IntrinsicsCovariance estimate_intrinsics_covariance(const Board& board,
                                                    std::span<const Corners> views,
                                                    const std::vector<bool>& used, double flatness,
                                                    const IntrinsicsSolution& solution);

}  // namespace infuse::target

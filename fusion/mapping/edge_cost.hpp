#pragma once

#include "fusion/mapping/pose_graph.hpp"

namespace infuse::mapping {

/// What is minimised over the poses, a sum over edges.
enum class Cost {
  /// χ² of the full information, as g2o states it: eᵀ Ω e,
  /// e = (translation, angle or vector part of the quaternion) of
  /// T_from_to⁻¹ T_map_from⁻¹ T_map_to.
  kInformation,
  /// κ |R_to − R_from R|²_F + τ |t_to − t_from − R_from t|², which certifiable solvers minimise
  /// (Rosen et al. 2019); κ and τ by `chordal_weights`.
  kChordal,
};

/// Weights of a rotation and of a translation in the chordal cost.
struct ChordalWeights {
  double rotation = 0, translation = 0;  ///< κ, τ
};

/// The isotropic weights that are nearest to an information in Kullback–Leibler divergence, in 2D
/// κ = I_angle, τ = 2 / tr(I_t⁻¹); in 3D κ = 3 / (2 tr(I_q⁻¹)), τ = 3 / tr(I_t⁻¹). A direction
/// without information counts with 1e-12 of the strongest.
template <int D>
ChordalWeights chordal_weights(const PoseMatrix<D>& information);

/// Cost of one edge about its two poses: cost(δ) ≈ cost + 2 gᵀ δ + δᵀ H δ, where δ are
/// perturbations (translation, rotation) in the frames of the poses, T ← T exp(δ).
template <int D>
struct EdgeSystem {
  double cost = 0;
  PoseMatrix<D> H_from_from, H_to_from, H_to_to;
  Eigen::Matrix<double, kPoseFreedom<D>, 1> g_from, g_to;
};

/// Cost of one edge at two poses (no unit).
template <int D>
double edge_cost(const PoseEdge<D>& edge, const Pose<D>& T_map_from, const Pose<D>& T_map_to,
                 Cost cost);

/// The same with its derivatives.
template <int D>
EdgeSystem<D> linearize_edge(const PoseEdge<D>& edge, const Pose<D>& T_map_from,
                             const Pose<D>& T_map_to, Cost cost);

/// Pose moved by a perturbation in its frame, to first order T exp(δ); needs no trigonometry.
template <int D>
Pose<D> perturb(const Pose<D>& T, const Eigen::Matrix<double, kPoseFreedom<D>, 1>& delta);

}  // namespace infuse::mapping

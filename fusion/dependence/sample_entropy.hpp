#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "fusion/dependence/estimate.hpp"

namespace infuse::dependence {

/// Differential entropy in nats, from samples and without a histogram. Samples that are not finite
/// are refused. Samples that repeat (8-bit values) have no density: where a distance of zero meets
/// the logarithm, the answer is a reason.

/// What m-spacing assumes.
struct SpacingOptions {
  int m = 0;                 ///< spacing in order statistics, below n/2; 0: cube root of n, rounded
  bool correct_bias = true;  ///< subtract the bias that P(2.20) has on a uniform density, exactly
};

/// The m-spacing estimate P(2.20), for scalars. Bias after Wieczorkowski and Grzegorzewski (1999).
Estimate entropy_spacing(std::span<const double> samples, const SpacingOptions& options = {});

/// k-nearest-neighbour estimate, P(2.21) for d dimensions and any k:
/// (d/n) Σ ln ρ_i + ln n + ln V_d − ψ(k), with V_d the volume of the unit ball.
/// @param samples  one sample a column, d rows
/// @param k        which neighbour, 1 … n − 1; 1 is P(2.21)
Estimate entropy_nearest_neighbour(const Eigen::Ref<const Eigen::MatrixXd>& samples, int k = 1);

/// What the spanning-tree estimate assumes.
struct SpanningTreeOptions {
  double alpha = 0.5;  ///< order of the Rényi entropy, inside (0, 1); γ = d (1 − α)
  /// ln β, P(2.23). Absent: found from trees over uniform samples in the unit cube, whose entropy
  /// is zero; as many samples as are given, 1000 at most.
  std::optional<double> log_beta;
  int calibration_sets = 8;  ///< how many uniform sets to average
  uint64_t seed = 1;         ///< of the uniform sets
};

/// Rényi entropy of order α from the minimum spanning tree, P(2.23). O(d n²) time, O(n) memory;
/// at most 50 000 samples.
/// @param samples  one sample a column, d rows
Estimate renyi_entropy_spanning_tree(const Eigen::Ref<const Eigen::MatrixXd>& samples,
                                     const SpanningTreeOptions& options = {});

/// ln β of P(2.23) for `samples` points in `dimensions` dimensions, by simulation: compute it once
/// where many sets of one size are asked. NaN never; 0 for arguments that make no tree.
double spanning_tree_log_beta(int dimensions, int samples, const SpanningTreeOptions& options = {});

}  // namespace infuse::dependence

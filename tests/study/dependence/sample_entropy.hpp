#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "fusion/dependence/estimate.hpp"

namespace infuse::study {

using dependence::Estimate;

/// Differential entropy in nats, from samples and without a histogram. Rejects samples that are not
/// finite. Repeated samples (8-bit values) have no density: a distance of zero gives a reason.

/// Settings of the m-spacing estimate.
struct SpacingOptions {
  int m = 0;                 ///< spacing in order statistics, below n/2; 0: rounded cube root of n
  bool correct_bias = true;  ///< subtract the exact bias of P(2.20) on a uniform density
};

/// Estimates the entropy of a scalar by m-spacings, P(2.20). Bias after Wieczorkowski and
/// Grzegorzewski (1999).
Estimate entropy_spacing(std::span<const double> samples, const SpacingOptions& options = {});

/// Estimates the entropy of a vector by k nearest neighbours, P(2.21) for d dimensions and any k:
/// (d/n) Σ ln ρ_i + ln n + ln V_d − ψ(k), with V_d the volume of the unit ball.
/// @param samples  one sample per column, d rows
/// @param k        order of the neighbour, 1 … n − 1; 1 is P(2.21)
Estimate entropy_nearest_neighbour(const Eigen::Ref<const Eigen::MatrixXd>& samples, int k = 1);

/// Settings of the spanning-tree estimate.
struct SpanningTreeOptions {
  double alpha = 0.5;  ///< order of the Rényi entropy, in (0, 1); γ = d (1 − α)
  /// ln β, P(2.23). Absent: simulated with trees over uniform samples in the unit cube, whose
  /// entropy is zero; as many samples as given, at most 1000.
  std::optional<double> log_beta;
  int calibration_sets = 8;  ///< number of uniform sets to average
  uint64_t seed = 1;         ///< seed of the uniform sets
};

/// Estimates the Rényi entropy of order α from the minimum spanning tree, P(2.23). O(d n²) time,
/// O(n) memory; at most 50 000 samples.
/// @param samples  one sample per column, d rows
Estimate renyi_entropy_spanning_tree(const Eigen::Ref<const Eigen::MatrixXd>& samples,
                                     const SpanningTreeOptions& options = {});

/// Simulates ln β of P(2.23) for `samples` points in `dimensions` dimensions: compute it once for
/// many sets of one size. Never NaN; 0 for arguments that make no tree.
double spanning_tree_log_beta(int dimensions, int samples, const SpanningTreeOptions& options = {});

}  // namespace infuse::study

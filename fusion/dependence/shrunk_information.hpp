#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace infuse::dependence {

/// Direction of the fast shrinkage coefficient.
enum class FastShrinkage {
  kAsPrinted,  ///< more correspondences shrink more: 0 at none, approaches 1
  kReversed,   ///< more correspondences shrink less: one minus the printed value
};

/// The O(1) shrinkage λ_e = 2/(1 + exp(−c/σ)) − 1, P(4.11), 0 … 1.
/// @param correspondences c, number of matched codewords
/// @param sigma           σ, roughly the usual number of codewords in a scan
/// Returns 1 (the target alone) for arguments that are not finite, a negative c or a σ ≤ 0.
double fast_shrinkage(double correspondences, double sigma,
                      FastShrinkage direction = FastShrinkage::kReversed);

/// Mutual information of two labels from few pairs: James–Stein frequencies P(4.8) shrunk towards
/// independent labels with known frequencies. The time of an evaluation grows with the number of
/// different pairs and labels, not with the square of the labels. Allocates nothing after
/// `reserve`d pairs.
class ShrunkInformation {
 public:
  /// `target`: frequency of each label, positive, with sum 1 (both variables have the same labels).
  explicit ShrunkInformation(std::vector<double> target);

  size_t labels() const { return target_.size(); }  ///< number of labels

  /// Forgets all pairs.
  void clear();

  /// Adds a pair of labels (each below `labels()`) with a positive weight.
  void add(uint32_t x, uint32_t y, double weight = 1);

  /// Sum of the weights, c of P(4.11).
  double total() const { return total_; }

  /// λ_s of P(4.10) for whole weights, 0 … 1; 1 for at most one pair.
  double optimal_shrinkage() const;

  /// Mutual information of λ T Tᵀ + (1 − λ) counts/total, nats; 0 without pairs.
  double value(double lambda) const;

 private:
  size_t cell(uint32_t x, uint32_t y) const { return x * target_.size() + y; }

  std::vector<double> target_, log_target_;
  double target_squares_ = 0;                        // Σ T²
  std::vector<double> joint_;                        // weights by pair of labels
  std::vector<std::pair<uint32_t, uint32_t>> seen_;  // pairs with a weight
  std::vector<double> x_, y_;                        // weights by label
  double total_ = 0;
};

}  // namespace infuse::dependence

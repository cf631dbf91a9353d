#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "fusion/dependence/label_dependence.hpp"
#include "fusion/streetmap/label_window.hpp"
#include "fusion/streetmap/local_grid.hpp"

namespace infuse::streetmap {

/// Scores labels against the features of a view; each view is evaluated with many labellings.
class ViewScore {
 public:
  virtual ~ViewScore() = default;

  /// Reserves memory for the given numbers of samples and labels.
  virtual void reserve(int samples, int labels) = 0;

  /// Prepares a view. Returns why it cannot be evaluated (static text), or "".
  virtual const char* prepare(const GridSamples& samples) = 0;

  /// Returns the score of one label per sample, labels of `window`; 0 if there is none. `fixed`
  /// hyper-parameters skip the cross-validation; `chosen`, if not null, receives those used (σ 0:
  /// none).
  virtual double evaluate(std::span<const int32_t> labels, const LabelWindow& window,
                          const std::optional<dependence::HyperParameters>& fixed,
                          dependence::HyperParameters* chosen = nullptr) = 0;
};

/// SMI by LSMI, I 3.3.1. Does not allocate after the first view of a size.
class LsmiScore final : public ViewScore {
 public:
  explicit LsmiScore(const dependence::FitOptions& fit) : dependence_(fit) {}

  void reserve(int samples, int labels) override;
  const char* prepare(const GridSamples& samples) override;
  double evaluate(std::span<const int32_t> labels, const LabelWindow& window,
                  const std::optional<dependence::HyperParameters>& fixed,
                  dependence::HyperParameters* chosen = nullptr) override;

 private:
  dependence::LabelDependence dependence_;
};

}  // namespace infuse::streetmap

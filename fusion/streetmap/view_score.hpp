#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fusion/dependence/label_dependence.hpp"
#include "fusion/streetmap/label_window.hpp"
#include "fusion/streetmap/local_grid.hpp"

namespace infuse::streetmap {

/// Measure by which the tracker weights a pose.
enum class ViewMeasure {
  kLsmi,        ///< SMI by LSMI, I 3.3.1
  kBlsmi,       ///< mean of LSMI over bags of the samples, I(2.9); for comparison with I table 3.6
  kBoundaries,  ///< correlation of kerb-like samples with the kerbs of the map, I(3.7–3.9); needs
                ///< colours; for comparison with I table 3.5
};

/// Scores labels against the features of a view; each view is evaluated with many labellings. Does
/// not allocate after the first view of a size.
class ViewScore {
 public:
  ViewScore(ViewMeasure measure, const dependence::FitOptions& fit);

  /// Reserves memory for the given numbers of samples and labels.
  void reserve(int samples, int labels);

  /// Prepares a view. Returns why it cannot be evaluated (static text), or "".
  const char* prepare(const GridSamples& samples);

  /// Returns the score of one label per sample, labels of `window`; 0 if there is none. `fixed`
  /// hyper-parameters skip the cross-validation; `chosen`, if not null, receives those used (σ 0:
  /// none).
  double evaluate(std::span<const int32_t> labels, const LabelWindow& window,
                  const std::optional<dependence::HyperParameters>& fixed,
                  dependence::HyperParameters* chosen = nullptr);

 private:
  const char* prepare_boundaries(const FeatureTable& features);
  double boundary_correlation(std::span<const int32_t> labels, const LabelWindow& window) const;

  ViewMeasure measure_;
  std::vector<dependence::LabelDependence> bags_;  // one for kLsmi
  FeatureTable bag_features_;
  std::vector<int32_t> bag_labels_;
  std::vector<double> boundary_strength_;  // likeness to a boundary, by sample
  double boundary_strength_norm_ = 0;
};

}  // namespace infuse::streetmap

#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fusion/dependence/label_dependence.hpp"
#include "fusion/streetmap/label_window.hpp"
#include "fusion/streetmap/local_grid.hpp"

namespace infuse::streetmap {

/// By what the tracker weighs a pose.
enum class ViewMeasure {
  kLsmi,   ///< SMI by LSMI, I 3.3.1
  kBlsmi,  ///< the mean of LSMI over bags of the samples, I(2.9): the comparison of I table 3.6
  kBoundaries,  ///< correlation of what looks like a kerb with the map's kerbs, I(3.7–3.9): the
                ///< comparison of I table 3.5; needs colours
};

/// How well labels fit what is seen, for one view after another, each asked with many labellings.
/// Allocates nothing after its first view of a size.
class ViewScore {
 public:
  ViewScore(ViewMeasure measure, const dependence::FitOptions& fit);

  /// Takes the memory for as many samples and labels as there may be.
  void reserve(int samples, int labels);

  /// Takes a view. Why it cannot be asked, static text; "" where it can.
  const char* prepare(const GridSamples& samples);

  /// The score of one label a sample, labels of `window`; 0 where it has none. `kept` leaves out
  /// the cross-validation; `chosen`, where not null, is what was kept or chosen (σ 0: nothing).
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
  std::vector<double> boundary_strength_;  // to a boundary, by sample
  double boundary_strength_norm_ = 0;
};

}  // namespace infuse::streetmap

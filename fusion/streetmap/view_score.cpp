#include "fusion/streetmap/view_score.hpp"

namespace infuse::streetmap {

void LsmiScore::reserve(int samples, int labels) {
  dependence_.reserve(samples, kFeatureCount, labels);
}

const char* LsmiScore::prepare(const GridSamples& samples) {
  dependence_.prepare(samples.features.matrix());
  return dependence_.reason();
}

double LsmiScore::evaluate(std::span<const int32_t> labels, const LabelWindow& window,
                           const std::optional<dependence::HyperParameters>& fixed,
                           dependence::HyperParameters* chosen) {
  if (chosen != nullptr) *chosen = {};
  const dependence::FitEstimate estimate =
      dependence_.evaluate(labels, window.label_count(), fixed);
  if (!estimate.usable()) return 0;
  if (chosen != nullptr) *chosen = fixed ? *fixed : estimate.hyper_parameters;
  return estimate.value;
}

}  // namespace infuse::streetmap

#pragma once

#include <vector>

#include "fusion/streetmap/view_score.hpp"

namespace infuse::streetmap {

/// Mean of LSMI over bags of the samples, I(2.9): the comparison of I table 3.6.
class BaggedLsmiScore final : public ViewScore {
 public:
  static constexpr size_t kBagCount = 4;

  explicit BaggedLsmiScore(const dependence::FitOptions& fit) : bags_(kBagCount, LsmiScore(fit)) {}

  void reserve(int samples, int labels) override;
  const char* prepare(const GridSamples& samples) override;
  double evaluate(std::span<const int32_t> labels, const LabelWindow& window,
                  const std::optional<dependence::HyperParameters>& fixed,
                  dependence::HyperParameters* chosen = nullptr) override;

 private:
  std::vector<LsmiScore> bags_;
  GridSamples bag_samples_;
  std::vector<int32_t> bag_labels_;
};

/// Correlation of kerb-like samples with the kerbs of the map, I(3.7–3.9): the comparison of
/// I table 3.5. Needs colours.
class BoundaryScore final : public ViewScore {
 public:
  void reserve(int samples, int labels) override;
  const char* prepare(const GridSamples& samples) override;
  double evaluate(std::span<const int32_t> labels, const LabelWindow& window,
                  const std::optional<dependence::HyperParameters>& fixed,
                  dependence::HyperParameters* chosen = nullptr) override;

 private:
  std::vector<double> strength_;  // likeness to a boundary, by sample
  double strength_norm_ = 0;
};

}  // namespace infuse::streetmap

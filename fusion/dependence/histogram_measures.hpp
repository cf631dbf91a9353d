#pragma once

#include <vector>

#include "fusion/dependence/estimate.hpp"
#include "fusion/dependence/joint_histogram.hpp"

namespace infuse::dependence {

/// Dependence measure of a joint histogram. Increases with dependence.
enum class Measure {
  kMutualInformation,             ///< I = H_x + H_y − H_xy, nats, P(2.13), I(2.3)
  kNormalisedMutualInformation,   ///< (H_x + H_y)/H_xy, 1 … 2, I(4.2)
  kChiSquared,                    ///< Σ (p − p_x p_y)²/(p_x p_y), P(3.25)
  kSquaredLossMutualInformation,  ///< half of χ²: I(4.3) without its spurious minus sign
};

/// A measure by its short name.
struct MeasureName {
  const char* name;  ///< as in options
  Measure measure;   ///< that it names
};

/// Every measure.
inline constexpr MeasureName kMeasureNames[] = {
    {"mi", Measure::kMutualInformation},
    {"nmi", Measure::kNormalisedMutualInformation},
    {"chi2", Measure::kChiSquared},
    {"smi", Measure::kSquaredLossMutualInformation},
};

/// Computes the plug-in measure of the table. The value is set wherever there is mass, with the
/// histogram's reason.
Estimate measure(Measure which, const JointHistogram& histogram);

/// Value of a measure and its derivative with respect to every normalised cell p(x, y), up to terms
/// that depend on x alone (they vanish when samples move along y).
struct Sensitivity {
  Estimate estimate;          ///< the value
  double total = 0;           ///< mass of the histogram
  std::vector<double> table;  ///< same shape as the histogram; 0 in empty cells
};

/// Fills `out` and reuses its memory.
void differentiate(Measure which, const JointHistogram& histogram, Sensitivity& out);

}  // namespace infuse::dependence

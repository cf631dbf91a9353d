#pragma once

#include <vector>

#include "fusion/dependence/count_entropy.hpp"
#include "fusion/dependence/estimate.hpp"
#include "fusion/dependence/joint_histogram.hpp"

namespace infuse::dependence {

/// A measure of dependence that a joint histogram gives. All but the distance grow with dependence.
enum class Measure {
  kMutualInformation,              ///< I = H_x + H_y − H_xy, nats, P(2.13), I(2.3)
  kNormalisedMutualInformation,    ///< (H_x + H_y)/H_xy, 1 … 2, I(4.2)
  kNormalisedInformationDistance,  ///< (H_xy − I)/H_xy, 0 … 1, falls with dependence
  kChiSquared,                     ///< Σ (p − p_x p_y)²/(p_x p_y), P(3.25)
  kSquaredLossMutualInformation,   ///< half of χ²: I(4.3) without its stray minus sign
};

/// The measure of the table as it is (plug-in). The value is given wherever there is mass, with the
/// histogram's own reason.
Estimate measure(Measure which, const JointHistogram& histogram);

/// The measure with another estimator of entropy. James–Stein and Dirichlet regularise the joint
/// frequencies (a target has one value a cell); Miller–Madow, Nemenman and Chao–Shen correct the
/// three entropies, so that χ² and SMI have no such form and the mutual information may come out
/// negative. Reason "fewer samples than bins" is lifted for the estimators made for that.
Estimate measure(Measure which, const JointHistogram& histogram,
                 const CountEntropyOptions& options);

/// The measure and its derivative with respect to every normalised cell p(x, y), up to terms that
/// depend on x alone (those vanish when samples move along y).
struct Sensitivity {
  Estimate estimate;
  double total = 0;           ///< mass of the histogram it belongs to
  std::vector<double> table;  ///< shaped as the histogram; 0 in empty cells
};

/// Fills `out`, whose memory is used again.
void differentiate(Measure which, const JointHistogram& histogram, Sensitivity& out);

}  // namespace infuse::dependence

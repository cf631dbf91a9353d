#pragma once

#include "fusion/dependence/histogram_measures.hpp"
#include "tests/study/dependence/count_entropy.hpp"

namespace infuse::study {

/// Computes a measure of a joint histogram with another estimator of entropy. James–Stein and
/// Dirichlet regularise the joint frequencies (a target has one value per cell). Miller–Madow,
/// Nemenman and Chao–Shen correct the three entropies: χ² and SMI have no such form, and mutual
/// information may be negative. The reason "fewer samples than bins" is lifted for estimators made
/// for few samples.
Estimate measure(dependence::Measure which, const dependence::JointHistogram& histogram,
                 const CountEntropyOptions& options);

}  // namespace infuse::study

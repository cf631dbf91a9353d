#pragma once

#include <cstdint>
#include <span>

#include "fusion/dependence/count_entropy.hpp"
#include "fusion/dependence/estimate.hpp"

namespace infuse::dependence {

/// Directed information from one sequence of labels to another, nats, P(6.1) with the causally
/// conditional entropy P(6.2), which conditions on the whole past Y^{i−1} (the thesis prints
/// Y_{i−1}): DI(X → Y) = Σ_i H(Y_i | Y^{i−1}) − H(Y_i | Y^{i−1}, X^i). It separates cause from
/// effect: I(X; Y) = DI(X → Y) + DI(past of Y → X).
///
/// The entropies are those of words of several labels, most of which never occur, so only
/// estimators without a vocabulary size apply: maximum likelihood, Miller–Madow and Chao–Shen.

/// Directed information of many observations of a pair of short sequences (the same road, driven
/// often).
/// @param x, y     observations of `length` labels, one after the other
/// @param delayed  conditions on X^{i−1} instead of X^i: the information of the past of X alone
Estimate directed_information(
    std::span<const int32_t> x, std::span<const int32_t> y, int length,
    CountEntropyOptions::Estimator estimator = CountEntropyOptions::Estimator::kMaximumLikelihood,
    bool delayed = false);

/// Directed information rate of one long stationary pair of sequences with a memory of `memory`
/// labels: nats per step, H(Y_i | Y_{i−m}^{i−1}) − H(Y_i | Y_{i−m}^{i−1}, X_{i−m}^{i}).
/// @param memory   m, 0 … 16; 0 is the mutual information of X_i and Y_i
/// @param delayed  leaves X_i out
Estimate directed_information_rate(
    std::span<const int32_t> x, std::span<const int32_t> y, int memory,
    CountEntropyOptions::Estimator estimator = CountEntropyOptions::Estimator::kMaximumLikelihood,
    bool delayed = false);

}  // namespace infuse::dependence

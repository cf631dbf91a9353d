#pragma once

#include <cstdint>
#include <span>

#include "fusion/dependence/gaussian_kernel.hpp"
#include "fusion/dependence/least_squares.hpp"

namespace infuse::study {

using dependence::FitEstimate;
using dependence::FitOptions;
using dependence::Samples;

/// LSMI with the paired model r(x, y) = Σ_l α_l G(x, x̃_l) L(y, ỹ_l), b coefficients instead of b²
/// (Suzuki et al. 2009): (H + λI)α = h with H = mean GGᵀ ∘ mean LLᵀ, h = mean G∘L. The linear form
/// is ½hᵀα − ½, the plug-in form hᵀα − ½αᵀHα − ½. Cross-validated like the product model.
FitEstimate paired_lsmi(const Samples& x, const Samples& y, const FitOptions& options);

/// MLMI I 2.1.2.3: mutual information in nats, by the paired model with α ≥ 0 that maximises mean
/// log r(x_i, y_i) subject to mean r(x_i, y_j) = 1 (Suzuki et al. 2009). The problem is concave;
/// expectation-maximisation stops when no α can gain more than 1e-4 nats, or after 500 steps. σ is
/// cross-validated by the held-out log-likelihood after at most 50 steps; `lambdas` and `form` are
/// not used, the returned λ is 0. Far slower than LSMI.
FitEstimate mlmi(const Samples& x, const Samples& y, const FitOptions& options);

/// MLMI of samples and labels 0 … label_count − 1, with the delta kernel for the labels.
FitEstimate mlmi(const Samples& x, std::span<const int32_t> labels, int label_count,
                 const FitOptions& options);

}  // namespace infuse::study

#pragma once

#include <span>

#include "fusion/dependence/estimate.hpp"

namespace infuse::study {

using dependence::Estimate;

/// Posterior mean entropy (nats) under Nemenman, Shafee and Bialek's mixture of Dirichlet priors,
/// P 2.4.2 [116]: integrates over the concentration β with the prior that makes the expected
/// entropy uniform on 0 … ln K. Counts as in count_entropy.hpp; they may be fractional. A single
/// word (K = 1) has entropy 0.
Estimate entropy_nemenman(std::span<const double> counts);

}  // namespace infuse::study

#pragma once

#include "fusion/registration/visual/codebook.hpp"

namespace infuse::registration {

/// Codebook of FPFH and SIFT, learned from simulated drives through invented towns:
/// `infuse-study codebook -o fusion/registration/visual/learned_codebook.inc` makes it anew.
const Codebook& learned_codebook();

}  // namespace infuse::registration

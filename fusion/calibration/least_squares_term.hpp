#pragma once

#include <memory>
#include <vector>

#include "fusion/calibration/dependence_term.hpp"

namespace infuse::calibration {

/// LSMI I(2.8) or BLSMI I(2.9) between several lidar features and several image features, each
/// scaled to unit variance. LSMI is one fit of at most 20 000 of the points; BLSMI is the mean over
/// bags of 2000. `columns`: one lidar feature each, one entry per point that is compared; `chosen`:
/// indices of these points.
std::unique_ptr<DependenceTerm> make_least_squares_term(
    const TermOptions& options, std::vector<uint32_t> chosen,
    const std::vector<std::vector<float>>& columns);

}  // namespace infuse::calibration

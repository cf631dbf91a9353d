#pragma once

#include <memory>

#include "fusion/calibration/dependence_term.hpp"

namespace infuse::study {

/// Mean product of one lidar and one image feature, I(4.4), the batch form of P(3.23). For
/// `TermOptions::make`.
std::unique_ptr<calibration::DependenceTerm> make_correlation_term(
    const calibration::TermOptions& options, const calibration::VisiblePoints& points);

}  // namespace infuse::study

#pragma once

#include <span>
#include <string>

#include "fusion/calibration/named_measures.hpp"

namespace infuse::study {

/// Measures that benchmarks compare with those of `infuse calibrate --measure`. The program does
/// not offer them: on simulated drives their results were wrong, at times with a small uncertainty.
std::span<const calibration::NamedMeasure> compared_measures();

/// Returns the measure of that name, of these or of `calibration::named_measures`; null if there is
/// none.
const calibration::NamedMeasure* find_any_measure(const std::string& name);

}  // namespace infuse::study

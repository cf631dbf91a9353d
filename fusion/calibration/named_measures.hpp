#pragma once

#include <span>
#include <string>
#include <vector>

#include "fusion/calibration/dependence_term.hpp"

namespace infuse::calibration {

/// Named sum of terms, as `infuse calibrate --measure NAME` offers it.
struct NamedMeasure {
  const char* name;                       ///< "joint"
  const char* description;                ///< a line for people
  std::vector<TermOptions> terms;         ///< what is added up
  std::vector<TermOptions> search_terms;  ///< `CalibrateOptions::search_terms`; empty: `terms`
  bool equalize_image = false;            ///< SceneOptions::equalize
  bool has_gradient = true;               ///< false: searched without
};

/// All named measures, the default first.
std::span<const NamedMeasure> named_measures();

/// Returns the measure of that name, or null.
const NamedMeasure* find_measure(const std::string& name);

}  // namespace infuse::calibration

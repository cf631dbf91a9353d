#pragma once

#include <span>
#include <string>
#include <vector>

#include "fusion/calibration/dependence_term.hpp"

namespace infuse::calibration {

/// What `infuse calibrate --measure NAME` offers: a name for a sum of terms.
struct NamedMeasure {
  const char* name;
  const char* description;
  std::vector<TermOptions> terms;
  std::vector<TermOptions> search_terms;  ///< CalibrateOptions::leading; empty: `terms`
  bool equalize_image = false;            ///< SceneOptions::equalize
  bool has_gradient = true;
};

/// All of them, the default first.
std::span<const NamedMeasure> named_measures();

/// Null where there is none of that name.
const NamedMeasure* find_measure(const std::string& name);

}  // namespace infuse::calibration

#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "fusion/calibration/calibrate.hpp"

namespace infuse::calibration {

/// A cause of a result's uncertainty.
struct CovariancePart {
  std::string name;  ///< "the scatter of the scenes", "the focal length", …
  geometry::Matrix6 covariance = geometry::Matrix6::Zero();
};

/// Returns the causes of `CalibrationResult::covariance`: scatter of the scenes, bias of the
/// measure, each parameter that is known to a standard deviation alone, and what is left of
/// `model_covariance` (contradictions, or what a caller added), as "the model". They add up to it.
std::vector<CovariancePart> covariance_parts(const CalibrationResult& result);

/// The part with the largest share of an axis' variance.
struct LargestPart {
  std::string name;
  double share = 0;  ///< 0 … 1
};

/// Returns the largest part of each axis: rotations, then translations.
std::array<LargestPart, 6> largest_parts(std::span<const CovariancePart> parts);

}  // namespace infuse::calibration

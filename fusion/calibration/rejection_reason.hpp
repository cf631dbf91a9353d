#pragma once

#include <optional>
#include <string>

#include "fusion/calibration/calibrate.hpp"

namespace infuse::calibration {

/// Standard deviations of the initial translation: 97 % of a Gaussian of three dimensions.
inline constexpr double kMaxTranslationSigmas = 3;

/// Returns why the result of a calibration cannot be used, or an empty text. `maximum` is that of
/// the last level, `moved` how far the reference camera lies from its initial position, m, and
/// `delay` what `CalibrationSteps::delay_along_travel` returns, s.
std::string rejection_reason(const CalibrationResult& result, const Maximum& maximum, double moved,
                             std::optional<double> delay, const CalibrateOptions& options);

}  // namespace infuse::calibration

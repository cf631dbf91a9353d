#pragma once

#include <filesystem>
#include <vector>

#include "daemon/tools/calibrate/calibration_run.hpp"

namespace infuse::daemon {

/// Writes `folder`/index.html, one self-contained page: the verdict, how far each axis moved and
/// its standard deviation, lidar over image before and after, the measure along and over pairs of
/// the six axes (P fig. 3.15), joint histograms, and the scenes' contributions. All runs use the
/// same pairs; the first one is drawn.
Result<void> write_report(const std::filesystem::path& folder, const ScenePairs& pairs,
                          const std::vector<CalibrationRun>& runs);

}  // namespace infuse::daemon

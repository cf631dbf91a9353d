#pragma once

#include <filesystem>
#include <vector>

#include "daemon/commands/calibration_run.hpp"

namespace infuse::daemon {

/// Writes `folder`/index.html, one page with everything in it: the answer, lidar over picture
/// before and after, the measure along and over pairs of the six axes (P fig. 3.15), joint
/// histograms, what each scene says. The runs are of the same pairs; the first one is drawn.
Result<void> write_report(const std::filesystem::path& folder, const ScenePairs& pairs,
                          const std::vector<CalibrationRun>& runs);

}  // namespace infuse::daemon

#pragma once

#include <ostream>
#include <string>

#include "drivers/measurement/error.hpp"

namespace infuse::study {

/// Asks a recorded drive whether its stated extrinsics or ours fit better. Calibrates on every
/// second image, and scores poses on the others: between the stated pose (0) and ours (1) and
/// beyond, and ours displaced across. The scores are the mean change of grey per pixel at depth
/// edges, which no calibration maximises, its rank along the rings, and the dependence. Then with
/// the halves exchanged. Errors: a drive that cannot be read.
Result<void> study_offset(std::ostream& out, const std::string& drive, const std::string& camera);

}  // namespace infuse::study

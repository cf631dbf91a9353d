#pragma once

#include <ostream>
#include <string>

#include "drivers/measurement/error.hpp"

namespace infuse::study {

/// Calibrates parts of a recorded drive: the first half, the second, every second image and the
/// others, and all; writes each result's difference from the stated pose, and the differences of
/// disjoint parts, in standard deviations of what differs from drive to drive. `other`, where not
/// empty, is another drive of the rig, compared by the differences from the stated poses. Errors: a
/// drive that cannot be read.
Result<void> study_recorded(std::ostream& out, const std::string& drive, const std::string& other);

}  // namespace infuse::study

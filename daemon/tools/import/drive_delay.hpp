#pragma once

#include <filesystem>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Measures how late the stamps of a drive's inertial unit are, by the motion of its first lidar in
/// the first minute, and writes it to drive.toml. What was found is noted; nothing is, where the
/// drive has no inertial unit, no lidar whose mounting is known, or no times.
void find_inertial_delay(const std::filesystem::path& drive, std::vector<Error>& notes);

}  // namespace infuse::daemon

#pragma once

#include <filesystem>
#include <vector>

#include "daemon/mapping/map_folder.hpp"
#include "daemon/mapping/map_settings.hpp"

namespace infuse::daemon {

/// Writes what several complete maps are made of to a new map folder, drive.json last, for
/// `finish_map` to join: their keyframes one map after the other, places, fixes and clouds. The
/// odometry of each drive stays as it was measured; what the maps made of it is found anew. A
/// folder whose drive.json is of these maps and settings is left as it is. Fails if a map is
/// damaged, is the target, or its lidar is mounted elsewhere than that of the first.
Result<void> merge_maps(const MapFolder& target, const std::vector<std::filesystem::path>& maps,
                        const MapSettings& settings);

}  // namespace infuse::daemon

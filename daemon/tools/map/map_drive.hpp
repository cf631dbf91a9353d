#pragma once

#include <string>

#include "daemon/mapping/map_folder.hpp"
#include "daemon/mapping/map_settings.hpp"
#include "daemon/setup/drive_setup.hpp"

namespace infuse::daemon {

/// Replays a drive by the odometry of one lidar and writes keyframes, clouds and fixes to a map
/// folder, drive.json last. A folder whose drive.json is of this drive, lidar and settings is left
/// as it is: `finish_map` goes on. Fails if it is of another drive or other settings. A run that is
/// interrupted before drive.json begins the replay anew and writes the same bytes.
Result<void> replay_to_map(const MapFolder& folder, SensorSetup& setup, size_t lidar,
                           const MapSettings& settings);

}  // namespace infuse::daemon

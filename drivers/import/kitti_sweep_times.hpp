#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::importers {

/// Times of one turn of KITTI's lidar.
struct TurnTimes {
  Stamp start;
  Stamp middle;  ///< the lidar faces forward, which triggers the cameras
  Stamp end;
};

/// Reads the stamps of velodyne_points/ in the raw layout: timestamps_start.txt, timestamps.txt
/// (the middle) and timestamps_end.txt. Entry k belongs to file k; it is absent if a stamp of it is
/// missing or wrong (the end not after the start, the middle outside them, a turn of more than a
/// second, a start before that of the turn before), which is noted. Without the files of the start
/// and the end, a turn extends half the usual time to either side of its middle. Errors: no stamp
/// file, a line that is not a time.
Result<std::vector<std::optional<TurnTimes>>> read_kitti_turn_times(
    const std::filesystem::path& folder, std::vector<Error>& notes);

}  // namespace infuse::importers

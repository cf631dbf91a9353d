#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/import/import_files.hpp"
#include "drivers/import/kitti_sweep_times.hpp"

namespace infuse::importers {

/// When a KITTI camera exposes its images.
struct ExposureTimes {
  Duration delay{0};  ///< usual time from the exposure to the camera's stamp
  Duration sigma{0};  ///< standard deviation of an exposure's time
  Error note;         ///< statement for the user
};

/// KITTI's cameras are triggered when the lidar faces forward, and stamped when the image has
/// arrived: the exposure of image k is 3 ms after the middle of turn k, to 3 ms (image gradients at
/// depth edges are largest there). Sets `times.exposure` of the images whose turn is known. Images
/// whose stamps do not follow the turns (more than 50 ms away, or scattered by more than 10 ms) are
/// left as they are. Errors: stamps more than a second away from the turns, as those of another
/// time zone.
Result<ExposureTimes> find_exposures(const std::string& camera,
                                     const std::vector<std::optional<TurnTimes>>& turns,
                                     std::vector<StampedFile>& images);

/// Fails if stamps and the middles of the turns of the same number differ by more than a second.
Result<void> check_same_clock(const std::string& what,
                              const std::vector<std::optional<TurnTimes>>& turns,
                              const std::vector<StampedFile>& files);

}  // namespace infuse::importers

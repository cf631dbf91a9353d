#pragma once

#include <filesystem>
#include <vector>

#include "daemon/pages/report_data.hpp"
#include "daemon/protocol/json.hpp"
#include "drivers/recording/trajectory_file.hpp"

namespace infuse::daemon {

/// A path of a vehicle in the frame of the truth, as the page draws it.
struct ComparedPath {
  Json path = nullptr;    ///< {x, y}, m
  Json errors = nullptr;  ///< {t, m}: s after the start, distance from the true position
};

/// The positions of the truth: {x, y}, thinned.
Json truth_json(const std::vector<recording::TrajectoryPose>& truth);

/// The moves of the cameras that a simulated drive states in truth/extrinsics.csv, once a second:
/// [{t, device, moved}]; empty without the file.
Json true_moves_json(const std::filesystem::path& drive, Stamp start);

/// Compares poses with the truth at their times. `move_first`: they are in a frame of their own and
/// are moved so that the first pose that has a true one lies on it. Null members without a true
/// pose at any pose's time.
ComparedPath compare_with_truth(const std::vector<ReportedPose>& poses,
                                const std::vector<recording::TrajectoryPose>& truth,
                                bool move_first, Stamp start);

}  // namespace infuse::daemon

#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/protocol/json.hpp"

namespace infuse::daemon {

/// The entries of the history, oldest first, and how many lines could not be read.
struct HistoryEntries {
  std::vector<Json> alerts, calibrations, health;
  size_t unreadable = 0;
};

/// Reads the lines of a history; leaves out what is more than `days` older than the newest.
HistoryEntries sort_entries(const std::vector<std::string>& lines, double days);

/// Stamp of an entry, ns.
int64_t stamp_of(const Json& entry);

/// A time in UTC; `form` as strftime: "{:%Y-%m}".
std::string utc_text(int64_t ns, const char* form);

/// T_camera_lidar of an entry of a calibration; nothing if it is not a rigid motion.
std::optional<Eigen::Isometry3d> calibration_of(const Json& entry);

/// The last calibration of each camera in each month, relative to its first one: rotation about and
/// translation along the camera's axes.
Json drift_of(const std::vector<Json>& calibrations);

/// Seconds at each level.
std::map<std::string, uint64_t> level_seconds(const std::vector<Json>& health);

}  // namespace infuse::daemon

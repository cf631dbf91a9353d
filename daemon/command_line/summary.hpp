#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/command_line/lidar_problems.hpp"
#include "daemon/pipeline/replay.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Result of a replay.
struct Summary {
  std::filesystem::path path;
  std::vector<Sensor> sensors;  ///< none if the drive was empty
  Totals totals;
  bool has_odometry = false;  ///< true if the drive has a source of odometry
  std::vector<Error> notes;   ///< problems of the files
  double host_s = 0;          ///< duration of the replay by the host's clock, s
  bool stopped = false;       ///< true if a signal ended the replay before the drive's end
};

/// Largest resident size of this process so far, MB.
double peak_memory_mb();

/// Formats the summary as one JSON object; keys in snake_case with units.
Json to_json(const Summary& summary);

/// Formats the summary as several lines of text.
std::string to_text(const Summary& summary);

/// Collects the summary of a finished replay; `host_s` and `stopped` are left to the caller.
Summary summarise(const Replay& replay);

/// Formats the counters of one sensor as several lines of text.
std::string sensor_text(const Sensor& sensor, const Totals& totals);

/// Finds the problems of all lidars.
std::vector<LidarProblem> find_problems(const Summary& summary);

/// Formats the state of odometry, one or two lines.
std::string odometry_text(const OdometryStatus& odometry);

}  // namespace infuse::daemon

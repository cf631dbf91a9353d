#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/pipeline/replay.hpp"
#include "daemon/protocol/counters_json.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// What a replay came to.
struct Summary {
  std::filesystem::path path;
  std::vector<Device> devices;
  Totals totals;
  bool has_odometry = false;  ///< something says how the vehicle moves
  std::vector<Error> notes;   ///< what was wrong with the files
  double host_s = 0;          ///< how long it took
  bool stopped = false;       ///< by a signal, before the drive's end
};

/// Largest resident size of this process so far, MB.
double peak_memory_mb();

/// For machines: one object, keys in snake_case with their units.
Json to_json(const Summary& summary);

/// For people: several lines.
std::string to_text(const Summary& summary);

/// What a replay came to, as far as it knows by itself.
Summary summarise(const Replay& replay);

/// What is known of one lidar, for people: several lines.
std::string device_text(const Device& device, const SensorCounters& counters, Level level);

/// The same of a camera, a bus, an inertial unit or a receiver.
std::string stream_text(const Device& device, const StreamCounters& counters, Level level);

/// What odometry has learned and done, for people: a line or two.
std::string odometry_text(const OdometryStatus& odometry);

}  // namespace infuse::daemon

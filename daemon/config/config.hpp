#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/odometry_settings.hpp"
#include "daemon/health/health_options.hpp"
#include "daemon/server/server_options.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// A lidar that the daemon listens to: one `[[lidar]]` table.
struct LidarOptions {
  std::string name = "lidar";
  std::string model;             ///< "HDL-32E", ...; empty: inferred, in a replay
  uint16_t port = 2368;          ///< UDP port of its data packets
  std::string sender;            ///< IPv4 address it sends from; empty: any
  std::string calibration;       ///< file of this unit; empty: the model's own table
  double cut_azimuth_deg = 180;  ///< where a sweep ends, clockwise from the front

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// Everything that the owner can set.
struct Config {
  std::string log_level = "info";    ///< trace, debug, info, warning, error, off
  ServerOptions socket;              ///< [socket]
  HealthOptions health;              ///< [health]
  OdometrySettings odometry;         ///< [odometry]
  std::vector<LidarOptions> lidars;  ///< [[lidar]]
};

/// The configuration that `text` states; `file` is for messages.
Result<Config> parse_config(std::string_view text, const std::string& file);

/// The same from a file, at most 1 MiB of it.
Result<Config> load_config(const std::filesystem::path& path);

}  // namespace infuse::daemon

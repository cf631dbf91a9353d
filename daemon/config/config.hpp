#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/calibration_settings.hpp"
#include "daemon/config/metrics_settings.hpp"
#include "daemon/config/odometry_settings.hpp"
#include "daemon/config/record_settings.hpp"
#include "daemon/config/sensor_options.hpp"
#include "daemon/config/streetmap_settings.hpp"
#include "daemon/health/health_options.hpp"
#include "daemon/server/server_options.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Everything that the owner can set.
struct Config {
  std::string log_level = "info";      ///< trace, debug, info, warning, error, off
  std::string rig;                     ///< rig.toml: where the sensors are mounted; empty: not told
  ServerOptions socket;                ///< [socket]
  HealthOptions health;                ///< [health]
  OdometrySettings odometry;           ///< [odometry]
  StreetMapSettings streetmap;         ///< [streetmap]
  CalibrationSettings calibration;     ///< [calibration]
  RecordSettings record;               ///< [record], live
  MetricsSettings metrics;             ///< [metrics], live
  std::vector<LidarOptions> lidars;    ///< [[lidar]]
  std::vector<CameraOptions> cameras;  ///< [[camera]], live
  std::vector<BusOptions> buses;       ///< [[can]], live
  GnssOptions gnss;                    ///< [gnss], live

  /// By key of the root, what the files say of it. By this two configurations are compared.
  std::map<std::string, std::string> source_text;

  /// Of the file; what it names is looked for there.
  std::filesystem::path folder;

  /// A path that the configuration names.
  std::filesystem::path resolve(const std::string& path) const { return folder / path; }
};

/// The configuration that `text` states; `file` is for messages.
Result<Config> parse_config(std::string_view text, const std::string& file);

/// The keys of the root of which the two say different things: "lidar", "health", ...
std::vector<std::string> changed_keys(const Config& a, const Config& b);

/// The same from a file of at most 1 MiB, and then from the files `path`.d/*.toml, in order of
/// their names: a later key overrides an earlier one, and a sensor of a name that an earlier file
/// has is changed in what the later file says of it.
Result<Config> load_config(const std::filesystem::path& path);

}  // namespace infuse::daemon

#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/calibration_settings.hpp"
#include "daemon/config/lcm_settings.hpp"
#include "daemon/config/map_settings.hpp"
#include "daemon/config/metrics_settings.hpp"
#include "daemon/config/mqtt_settings.hpp"
#include "daemon/config/odometry_settings.hpp"
#include "daemon/config/record_settings.hpp"
#include "daemon/config/sensor_options.hpp"
#include "daemon/config/streetmap_settings.hpp"
#include "daemon/config/view_settings.hpp"
#include "daemon/health/health_options.hpp"
#include "daemon/server/server_options.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// The configuration.
struct Config {
  std::string log_level = "info";      ///< trace, debug, info, warning, error, off
  std::string version;                 ///< its owner's name of this configuration; empty: none
  std::string rig;                     ///< path of rig.toml, the sensors' mounts; empty: none
  ServerOptions socket;                ///< [socket]
  HealthOptions health;                ///< [health]
  OdometrySettings odometry;           ///< [odometry]
  StreetMapSettings streetmap;         ///< [streetmap]
  MapLocationSettings map;             ///< [map]
  CalibrationSettings calibration;     ///< [calibration]
  RecordSettings record;               ///< [record], live
  MetricsSettings metrics;             ///< [metrics], live
  MqttSettings mqtt;                   ///< [mqtt], live
  LcmSettings lcm;                     ///< [lcm], live
  ViewSettings view;                   ///< [view]
  std::vector<LidarOptions> lidars;    ///< [[lidar]]
  std::vector<CameraOptions> cameras;  ///< [[camera]], live
  std::vector<BusOptions> buses;       ///< [[can]], live
  GnssOptions gnss;                    ///< [gnss], live

  /// File and line of each table that is given, by its name: "metrics".
  std::map<std::string, std::string> where;

  /// Tells it from others: of the bytes of its files and of the rig, 16 hexadecimal digits. Empty
  /// if it was not loaded from a file.
  std::string digest;

  /// Source text by key of the root table, for comparing configurations.
  std::map<std::string, std::string> source_text;

  /// Folder of the file; relative paths in it start there.
  std::filesystem::path folder;

  /// Returns where a table is given, for messages.
  std::string where_is(const std::string& table) const {
    const auto found = where.find(table);
    return found == where.end() ? "[" + table + "]" : found->second;
  }

  /// Returns a path of the configuration, relative to its folder; an address (http://) as it is.
  std::filesystem::path resolve(const std::string& path) const {
    return path.starts_with("http://") ? std::filesystem::path(path) : folder / path;
  }
};

/// Parses a configuration; `file` is for messages.
Result<Config> parse_config(std::string_view text, const std::string& file);

/// Returns the keys of the root table that differ: "lidar", "health", ...
std::vector<std::string> changed_keys(const Config& a, const Config& b);

/// Loads a file of at most 1 MiB, then the files `path`.d/*.toml in order of their names. A later
/// key overrides an earlier one; a later sensor table changes the keys it states of an earlier
/// sensor with the same name.
Result<Config> load_config(const std::filesystem::path& path);

}  // namespace infuse::daemon

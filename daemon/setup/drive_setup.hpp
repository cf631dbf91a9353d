#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "daemon/config/config.hpp"
#include "daemon/setup/sensor_setup.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// What the command line says about the lidars of a drive; it precedes drive.toml.
struct LidarOverrides {
  const lidar::LidarModel* model = nullptr;  ///< null: not said
  std::filesystem::path calibration{};       ///< calibration file of the unit; empty: none
};

/// The model that `--model` names; null if it is empty. Errors: unknown, with those that are known.
Result<const lidar::LidarModel*> requested_model(const std::string& name);

/// Sets up the sensors of a drive folder or a bare capture (`find_capture_parts`). In a drive,
/// drive.toml names the lidars; in a bare capture, `lidars` of the configuration does, or if it is
/// empty, every stream of data packets at the beginning of the capture is a lidar. The model is
/// that of `overrides` if given, else the configured one, else the one inferred from the packets.
/// The calibration of a lidar whose units differ is that of `overrides` if given, else the
/// configured one, else the one in its packets.
Result<SensorSetup> open_drive(const std::filesystem::path& path,
                               const std::vector<LidarOptions>& lidars,
                               const LidarOverrides& overrides);

}  // namespace infuse::daemon

#pragma once

#include <vector>

#include "daemon/config/config.hpp"
#include "daemon/setup/sensor_setup.hpp"
#include "drivers/recording/drive_writer.hpp"

namespace infuse::daemon {

/// The `drive.toml` of a recording of this host's sensors, and the other files that belong in its
/// folder.
struct DescribedDrive {
  recording::DriveDescription description;
  std::vector<recording::DriveWriter::CopiedFile> copies;
  std::vector<std::string>
      not_recorded;  ///< sensors that a drive cannot hold, as sentences for the log
};

/// Describes the drive that a recording of these sensors produces: all lidars in one capture, the
/// cameras of the rig, the frames of all CAN buses with the signals of the first bus that has a
/// DBC, and the GNSS receiver.
DescribedDrive describe_drive(const Config& config, const SensorSetup& setup);

}  // namespace infuse::daemon

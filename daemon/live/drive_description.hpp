#pragma once

#include <vector>

#include "daemon/live/live_setup.hpp"
#include "drivers/recording/drive_writer.hpp"

namespace infuse::daemon {

/// What a drive of this host's sensors says of them, and what belongs into its folder besides.
struct DescribedDrive {
  recording::DriveDescription description;
  std::vector<recording::DriveWriter::CopiedFile> copies;
  std::vector<std::string> not_recorded;  ///< what a drive cannot say, for a person
};

/// The drive that a recording of these sensors makes: all lidars in one capture, the cameras of the
/// rig, the frames of all buses with the signals of the first that has any, and the receiver.
DescribedDrive describe_drive(const Config& config, const LiveSetup& setup);

}  // namespace infuse::daemon

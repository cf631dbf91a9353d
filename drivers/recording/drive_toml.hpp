#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/recording/drive.hpp"

namespace infuse::recording {

/// Parses a drive.toml. Errors contain the file name and the line: "drive.toml:12: unknown key
/// 'modle' (known keys: …)". Text longer than 1 MiB is an error.
Result<DriveDescription> parse_drive(std::string_view text, const std::string& file = "drive.toml");

/// Formats a description so that `parse_drive` returns an equal one.
std::string format_drive(const DriveDescription& description);

/// Parses a rig.toml: the [[lidar]] and [[camera]] tables of a drive.toml, without files.
Result<Rig> parse_rig(std::string_view text, const std::string& file = "rig.toml");

/// Formats a rig so that `parse_rig` returns an equal one.
std::string format_rig(const Rig& rig);

/// Reads a rig.toml from disk.
Result<Rig> read_rig(const std::filesystem::path& path);

/// Reads the rig.toml of a vehicle; also refuses what no vehicle has (`find_impossible`).
Result<Rig> read_vehicle_rig(const std::filesystem::path& path);
/// Writes a rig.toml. Fails if the rig is invalid or the file cannot be written.
Result<void> write_rig(const std::filesystem::path& path, const Rig& rig);

}  // namespace infuse::recording

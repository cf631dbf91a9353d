#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/recording/drive.hpp"

namespace infuse::recording {

/// Reads the text of a drive.toml. Errors carry file name and line: "drive.toml:12: unknown key
/// 'modle' (known keys: …)". Text longer than 1 MiB is refused.
Result<DriveDescription> parse_drive(std::string_view text, const std::string& file = "drive.toml");

/// The text that `parse_drive` reads back to an equal description.
std::string format_drive(const DriveDescription& description);

/// Reads the text of a rig.toml: the [[lidar]] and [[camera]] tables of a drive.toml, without
/// files.
Result<Rig> parse_rig(std::string_view text, const std::string& file = "rig.toml");

/// The text that `parse_rig` reads back to an equal rig.
std::string format_rig(const Rig& rig);

/// A rig.toml on disk.
Result<Rig> read_rig(const std::filesystem::path& path);
Result<void> write_rig(const std::filesystem::path& path, const Rig& rig);

}  // namespace infuse::recording

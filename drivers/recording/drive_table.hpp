#pragma once

#include <string>

#include "drivers/measurement/error.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/toml_library.hpp"

namespace infuse::recording {

/// Reads the TOML of a drive.toml that is parsed already (`parse_toml`), as `parse_drive` reads its
/// text.
Result<DriveDescription> parse_drive(const toml::table& table, const std::string& file);

}  // namespace infuse::recording

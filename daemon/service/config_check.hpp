#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config/config.hpp"
#include "daemon/protocol/json.hpp"

namespace infuse::daemon {

/// Opens the maps and compares every file of them with its checksum.
Result<void> check_maps(const Config& config);

/// What --check-config finds.
struct ConfigCheck {
  std::string file;
  std::string digest, version;  ///< as `Config`; empty if the file cannot be read
  std::optional<Error> wrong;   ///< what the daemon would refuse
  std::vector<Error> notes;     ///< what is probably unintended, or does not exist at present
};

/// Sets up what a live run with this configuration would: sensors and maps. Devices may be missing:
/// the daemon waits for them.
ConfigCheck check_config(const std::filesystem::path& file);

/// One object: `file`, `valid`, `config_digest`, `config_version`, `error` and `notes`.
Json to_json(const ConfigCheck& check);

}  // namespace infuse::daemon

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/toml_library.hpp"

namespace infuse::recording {

/// Reads a table that maps quantities to CAN signals, such as drive.toml's [can.signals]. Each
/// entry is `yaw_rate = "MESSAGE.SIGNAL"` or a table with the keys signal, scale and unit. Returns
/// an error if the table is invalid.
std::optional<Error> read_can_signals(const toml::table& source, const std::string& file,
                                      std::vector<CanSignal>& signals);

}  // namespace infuse::recording

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/recording/drive.hpp"
#include "drivers/recording/toml_library.hpp"

namespace infuse::recording {

/// Reads a table that maps quantities to signals, as drive.toml's [can.signals]:
/// `yaw_rate = "MESSAGE.SIGNAL"`, or a table of signal, scale and unit. What is wrong, or nothing.
std::optional<Error> read_can_signals(const toml::table& source, const std::string& file,
                                      std::vector<CanSignal>& signals);

}  // namespace infuse::recording

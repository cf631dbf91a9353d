#pragma once

#include <string>

namespace infuse::daemon {

/// Sends the log of the program `name` to the journal, by level, where that is where standard error
/// goes; else to standard error.
void set_up_logging(const std::string& name);

}  // namespace infuse::daemon

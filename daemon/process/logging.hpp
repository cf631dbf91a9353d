#pragma once

#include <string>

namespace infuse::daemon {

/// Sends the log of the program `name` to the journal, with levels, if standard error is the
/// journal's; otherwise to standard error.
void set_up_logging(const std::string& name);

}  // namespace infuse::daemon

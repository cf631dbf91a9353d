#pragma once

#include "daemon/command_line/tool.hpp"

namespace infuse::daemon {

/// Declares `infuse map`, its arguments and its examples.
Command declare_map(CLI::App& infuse);

}  // namespace infuse::daemon

#pragma once

#include "daemon/command_line/tool.hpp"

namespace infuse::daemon {

/// Declares `infuse fleet`, its arguments and its examples.
Command declare_fleet(CLI::App& infuse);

}  // namespace infuse::daemon

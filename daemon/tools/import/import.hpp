#pragma once

#include "daemon/command_line/tool.hpp"

namespace infuse::daemon {

/// Declares `infuse import`, its arguments and its examples.
Command declare_import(CLI::App& infuse);

}  // namespace infuse::daemon

#pragma once

#include "daemon/command_line/tool.hpp"

namespace infuse::daemon {

/// Declares `infuse export`, its arguments and its examples.
Command declare_export(CLI::App& infuse);

}  // namespace infuse::daemon

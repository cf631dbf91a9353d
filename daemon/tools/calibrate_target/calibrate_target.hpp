#pragma once

#include "daemon/command_line/tool.hpp"

namespace infuse::daemon {

/// Declares `infuse calibrate-target`, its arguments and its examples.
Command declare_calibrate_target(CLI::App& infuse);

}  // namespace infuse::daemon

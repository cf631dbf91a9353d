#pragma once

#include "daemon/command_line/tool.hpp"

namespace infuse::daemon {

/// Declares `infuse calibrate-intrinsics`, its arguments and its examples.
Command declare_calibrate_intrinsics(CLI::App& infuse);

}  // namespace infuse::daemon

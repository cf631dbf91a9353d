#pragma once

#include "daemon/command_line/tool.hpp"

namespace infuse::daemon {

/// Declares `infuse calibrate`, its arguments and its examples.
Command declare_calibrate(CLI::App& infuse);

}  // namespace infuse::daemon

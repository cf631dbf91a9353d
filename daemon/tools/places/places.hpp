#pragma once

#include "daemon/command_line/tool.hpp"

namespace infuse::daemon {

/// Declares `infuse places`, its arguments and its examples.
Command declare_places(CLI::App& infuse);

}  // namespace infuse::daemon

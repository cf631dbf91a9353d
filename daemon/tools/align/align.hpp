#pragma once

#include "daemon/command_line/tool.hpp"

namespace infuse::daemon {

/// Declares `infuse align`, its arguments and its examples.
Command declare_align(CLI::App& infuse);

}  // namespace infuse::daemon

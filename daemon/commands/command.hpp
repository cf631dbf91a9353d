#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace infuse::daemon {

/// A sub-command of `infuse`: does its work after the arguments were parsed, and gives the exit
/// code.
using Command = std::function<int()>;

/// Each declares one sub-command and what it takes.
Command declare_status(CLI::App& infuse);
Command declare_watch(CLI::App& infuse);
Command declare_inspect(CLI::App& infuse);
Command declare_decode(CLI::App& infuse);
Command declare_import(CLI::App& infuse);

}  // namespace infuse::daemon

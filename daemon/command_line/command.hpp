#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <span>

namespace infuse::daemon {

/// A sub-command of `infuse`.
struct Command {
  CLI::App* app;  ///< its `parsed()` is true if the sub-command was given
  std::function<int()>
      run;  ///< runs the command after the arguments have been parsed; returns the exit code
};

/// Parses the arguments of `infuse` and runs the command of `commands` that they name; returns the
/// exit code. Logs to standard error.
int run_command(CLI::App& infuse, std::span<const Command> commands, int argc, char** argv);

}  // namespace infuse::daemon

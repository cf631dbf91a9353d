#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "daemon/command_line/exit_code.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Parses the command line. Gives the exit code where the program is to end at once: help was
/// requested, or the usage was wrong; both have been printed then.
std::optional<int> parse_arguments(CLI::App& app, int argc, char** argv);

/// Prints "program: message" to standard error and gives `code` back.
int print_error(const std::string& program, const Error& error, ExitCode code);

/// A replay's `--rate`: nothing for "max", else the number, 0.01 ... 1000.
Result<std::optional<double>> parse_rate(const std::string& text);

}  // namespace infuse::daemon

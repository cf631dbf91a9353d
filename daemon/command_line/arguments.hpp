#pragma once

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <optional>
#include <string>

#include "daemon/command_line/exit_code.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Parses the command line. Returns the exit code if the program is to end at once: help was
/// requested or the usage is wrong, and the text has been printed. What is wrong begins with the
/// program's name; for a mistyped sub-command it suggests the nearest one.
std::optional<int> parse_arguments(CLI::App& app, int argc, char** argv);

/// Appends examples to the help text of a program or sub-command, one per line.
void set_examples(CLI::App& app, std::initializer_list<const char*> examples);

/// Prints "program: message" to standard error and returns `code`.
int print_error(const std::string& program, const Error& error, ExitCode code);

/// Parses a replay's `--rate`: nothing for "max", otherwise the factor, 0.01 … 1000.
Result<std::optional<double>> parse_rate(const std::string& text);

}  // namespace infuse::daemon

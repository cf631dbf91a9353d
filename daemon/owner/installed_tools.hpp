#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <set>
#include <string>

namespace infuse::daemon {

/// Folder of the tools' programs: $INFUSE_EXEC_PATH, or libexec/infuse beside the folder of this
/// program.
std::filesystem::path tools_folder();

/// Names of the tools in a folder, those of other authors too: what follows "infuse-" in the names
/// of its programs.
std::set<std::string> installed_tools(const std::filesystem::path& folder);

/// Runs the tool that the first argument names, in this process's place, with the arguments that
/// follow. Returns if there is none to run: an exit code, with the message printed, for a tool of
/// `kTools` that is not installed or cannot be run; otherwise nothing, after the tools that are
/// installed were added to the help of `infuse`, whose own commands are declared already.
std::optional<int> start_tool(CLI::App& infuse, int argc, char** argv);

}  // namespace infuse::daemon

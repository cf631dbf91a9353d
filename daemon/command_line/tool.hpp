#pragma once

#include <array>
#include <string>

#include "daemon/command_line/command.hpp"

namespace infuse::daemon {

/// A tool: a command that is outside of `infuse`, which `infuse NAME` starts as infuse-NAME.
struct Tool {
  const char* name;
  const char* description;
};

/// The tools of the package infuse-tools.
inline constexpr std::array<Tool, 9> kTools = {{
    {"align", "find the pose of one sweep in another's frame"},
    {"calibrate",
     "estimate the pose of a camera relative to the lidar from drives, without targets"},
    {"calibrate-intrinsics", "estimate the intrinsics of a camera from images of a checkerboard"},
    {"calibrate-target", "estimate the pose of a camera relative to the lidar from checkerboards"},
    {"export", "convert a drive to another format"},
    {"fleet", "pool the calibrations of many drives and vehicles, and find drift"},
    {"import", "convert a recording in another format to a drive"},
    {"map", "make a map of a drive; optimise pose graphs"},
    {"places", "find the images or sweeps of a drive among those of another"},
}};

/// The tool of `kTools` with this name; null if there is none.
const Tool* find_tool(const std::string& name);

/// Declares the sub-command of a tool of `kTools`, with its description.
CLI::App* add_tool(CLI::App& infuse, const Tool& tool);

/// All that the program infuse-NAME does: parses its arguments as those of `infuse NAME` and runs
/// what `declare` declares; returns the exit code.
int run_tool(const char* name, Command (*declare)(CLI::App& infuse), int argc, char** argv);

}  // namespace infuse::daemon

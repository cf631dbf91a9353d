#include "daemon/command_line/tool.hpp"

#include <algorithm>
#include <vector>

#include "daemon/command_line/version.hpp"
#include "drivers/measurement/block_sizes.hpp"

namespace infuse::daemon {

const Tool* find_tool(const std::string& name) {
  const auto found =
      std::ranges::find_if(kTools, [&](const Tool& tool) { return name == tool.name; });
  return found == kTools.end() ? nullptr : &*found;
}

CLI::App* add_tool(CLI::App& infuse, const Tool& tool) {
  return infuse.add_subcommand(tool.name, tool.description);
}

int run_tool(const char* name, Command (*declare)(CLI::App& infuse), int argc, char** argv) {
  fix_block_sizes();
  std::string program = "infuse";
  std::string command = name;
  std::vector<char*> arguments = {program.data(), command.data()};
  arguments.insert(arguments.end(), argv + std::min(argc, 1), argv + argc);
  CLI::App infuse;
  infuse.require_subcommand(1);
  const std::array commands = {declare(infuse)};
  commands[0].app->set_version_flag("--version", version());
  return run_command(infuse, commands, static_cast<int>(arguments.size()), arguments.data());
}

}  // namespace infuse::daemon

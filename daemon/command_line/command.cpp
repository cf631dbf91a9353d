#include "daemon/command_line/command.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "daemon/command_line/arguments.hpp"

namespace infuse::daemon {

int run_command(CLI::App& infuse, std::span<const Command> commands, int argc, char** argv) {
  if (const auto code = parse_arguments(infuse, argc, argv)) return *code;
  spdlog::set_default_logger(spdlog::stderr_color_mt("infuse"));
  for (const Command& command : commands) {
    if (command.app->parsed()) return command.run();
  }
  return kUsage;
}

}  // namespace infuse::daemon

// infuse: the command-line tool. The owner's commands are files in daemon/owner, the tools programs
// of their own.

#include <iostream>
#include <string>
#include <vector>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/version.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/owner/installed_tools.hpp"
#include "drivers/measurement/block_sizes.hpp"

namespace infuse::daemon {
namespace {

/// The arguments, with `infuse help [COMMAND]` as `infuse [COMMAND] --help`.
std::vector<char*> with_help_option(int argc, char** argv) {
  static std::string option = "--help";
  std::vector<char*> arguments(argv, argv + argc);
  if (argc > 1 && argv[1] == std::string("help")) {
    arguments.erase(arguments.begin() + 1);
    arguments.push_back(option.data());
  }
  return arguments;
}

int run(int argc, char** argv) {
  CLI::App app(
      "infuse: queries and controls the running daemon (infused), and works on recordings and "
      "calibrations.",
      "infuse");
  set_examples(app, {"infuse status", "infuse inspect drive.pcap"});
  app.set_version_flag("--version", version());
  app.require_subcommand(1);
  const std::vector<Command> commands = {
      declare_status(app),      declare_watch(app),       declare_wait_ready(app),
      declare_inspect(app),     declare_decode(app),      declare_streetmap(app),
      declare_evaluate(app),    declare_calibration(app), declare_calibrations(app),
      declare_recalibrate(app), declare_apply(app),       declare_rollback(app),
      declare_freeze(app),      declare_record(app),      declare_odometry(app),
      declare_history(app),     declare_report(app),      declare_config(app),
      declare_diagnose(app)};
  if (const auto code = start_tool(app, argc, argv)) return *code;
  if (argc < 2) {
    std::cout << app.help();
    return kUsage;
  }
  return run_command(app, commands, argc, argv);
}

}  // namespace
}  // namespace infuse::daemon

int main(int argc, char** argv) {
  infuse::fix_block_sizes();
  auto arguments = infuse::daemon::with_help_option(argc, argv);
  return infuse::daemon::run(static_cast<int>(arguments.size()), arguments.data());
}

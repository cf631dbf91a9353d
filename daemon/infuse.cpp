// infuse: the command-line tool. Each sub-command is a file in daemon/commands.

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <vector>

#include "daemon/command_line/arguments.hpp"
#include "daemon/commands/command.hpp"
#include "drivers/measurement/block_sizes.hpp"

namespace infuse::daemon {
namespace {

int run(int argc, char** argv) {
  CLI::App app(
      "infuse: queries and controls the running daemon (infused), and works on recordings and "
      "calibrations.");
  set_examples(app, {"infuse status", "infuse inspect drive.pcap"});
  app.set_version_flag("--version", INFUSE_VERSION);
  app.require_subcommand(1);
  const std::vector<Command> commands = {
      declare_status(app),      declare_watch(app),     declare_wait_ready(app),
      declare_inspect(app),     declare_decode(app),    declare_import(app),
      declare_streetmap(app),   declare_evaluate(app),  declare_calibration(app),
      declare_recalibrate(app), declare_apply(app),     declare_rollback(app),
      declare_freeze(app),      declare_calibrate(app), declare_calibrate_target(app),
      declare_record(app),      declare_odometry(app),  declare_align(app),
      declare_history(app),     declare_export(app),    declare_report(app),
      declare_map(app),         declare_places(app),    declare_fleet(app)};
  if (const auto code = parse_arguments(app, argc, argv)) return *code;
  spdlog::set_default_logger(spdlog::stderr_color_mt("infuse"));
  for (const Command& command : commands) {
    if (command.app->parsed()) return command.run();
  }
  return kUsage;
}

}  // namespace
}  // namespace infuse::daemon

int main(int argc, char** argv) {
  infuse::fix_block_sizes();
  return infuse::daemon::run(argc, argv);
}

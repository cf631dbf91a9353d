// infused: the daemon. Runs the pipeline on the sensors of this host or on a recorded drive.

#include <spdlog/spdlog.h>

#include <cstdlib>
#include <iostream>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/version.hpp"
#include "daemon/config/config.hpp"
#include "daemon/process/logging.hpp"
#include "daemon/process/service_user.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/run/run_live.hpp"
#include "daemon/run/run_replay.hpp"
#include "daemon/service/config_check.hpp"
#include "daemon/service/release_check.hpp"
#include "drivers/measurement/block_sizes.hpp"
#include "drivers/text/printable.hpp"

namespace infuse::daemon {
namespace {

/// What to do instead of a run.
struct Checks {
  bool config = false;
  bool self_test = false;
};

/// --check-config by root reads what the service can read.
constexpr const char* kAsService = "checked as the service's user, infuse";

void declare_options(CLI::App& app, RunOptions& options, Checks& checks) {
  app.description(
      "infused: processes lidars, cameras and odometry on the vehicle and publishes sensor "
      "health,\n"
      "calibrations and poses over a socket (see: infuse status, infuse watch).");
  app.set_version_flag("--version", version());
  app.add_option("--config", options.config, "configuration file (TOML)")->type_name("FILE");
  app.add_flag("--check-config", checks.config, "check the configuration and exit");
  app.add_flag("--self-test", checks.self_test,
               "test this release against the configuration, its maps and the saved state, decode "
               "generated packets, and exit");
  app.add_option("--replay", options.replay,
                 "replay a drive folder, or a bare pcap or pcapng file, and print a summary")
      ->type_name("PATH");
  app.add_option("--rate", options.rate,
                 "replay: factor of real time, or max (the default without --view) for as fast as "
                 "possible")
      ->type_name("R|max");
  auto* view = app.add_flag("--view", options.view,
                            "replay: show it in a browser, at [view] port or 9468; begin when the "
                            "page is opened, stay at the end until Ctrl-C");
  app.add_flag("--no-wait", options.no_wait,
               "replay: with --view, begin at once and end with the drive")
      ->needs(view);
  app.add_option("--reports", options.reports,
                 "replay: write every report to this file; the same drive gives the same bytes")
      ->type_name("FILE");
  app.add_option("--trajectory", options.trajectory,
                 "replay: write the vehicle's pose at the end of each sweep, in the map frame if "
                 "there is a map; TUM format, or KITTI format if the name ends in .kitti")
      ->type_name("FILE");
  app.add_option("--state", options.state,
                 "replay: restore calibrations from this folder and save them there (default: use "
                 "the drive's); --self-test: state directory (default: $STATE_DIRECTORY)")
      ->type_name("DIR");
  app.add_option("--socket", options.socket, "socket for clients")->type_name("PATH");
  app.add_option(
         "--mcap", options.mcap,
         "write sensor data, deskewed clouds, poses, alerts and health to this file as ROS 2 "
         "messages, live or in a replay")
      ->type_name("FILE");
  app.add_option("--model", options.model, "replay: model of the lidar, if it cannot be inferred")
      ->type_name("NAME");
  app.add_option("--calibration", options.calibration,
                 "replay: db.xml of an HDL-64E, angle file of a Hesai")
      ->type_name("FILE");
  app.add_flag("--json", options.json, "replay, --check-config: print one JSON object");
  set_examples(app, {"infused --config /etc/infuse/infused.toml",
                     "infused --replay drive/ --rate 1 --json"});
}

int check(const RunOptions& options) {
  if (options.config.empty()) {
    return print_error(kProgram, {"no configuration to check", "", "--config FILE"}, kUsage);
  }
  const auto service = become_user(kServiceUser);
  if (!service) return print_error(kProgram, service.error(), kFailure);
  const ConfigCheck checked = check_config(options.config);
  if (options.json) {
    std::cout << json_text(to_json(checked)) << "\n";
    return checked.wrong ? kUsage : kDone;
  }
  for (const Error& note : checked.notes) {
    std::cout << "note: " << text::printable(note.message()) << "\n";
  }
  if (*service) std::cout << "note: " << kAsService << "\n";
  if (checked.wrong) return print_error(kProgram, *checked.wrong, kUsage);
  std::cout << options.config << ": the configuration is valid\n";
  return kDone;
}

int test_itself(const RunOptions& options, const Config& config) {
  if (options.config.empty()) {
    return print_error(kProgram, {"no configuration to test with", "", "--config FILE"}, kUsage);
  }
  const char* state = std::getenv("STATE_DIRECTORY");
  return self_test(config,
                   !options.state.empty() ? options.state
                   : state != nullptr     ? state
                                          : "",
                   std::cout);
}

int run(int argc, char** argv) {
  CLI::App app;
  RunOptions options;
  Checks checks;
  declare_options(app, options, checks);
  if (const auto code = parse_arguments(app, argc, argv)) return *code;
  set_up_logging(kProgram);

  if (checks.config) return check(options);
  Config config;
  if (!options.config.empty()) {
    auto loaded = load_config(options.config);
    if (!loaded) return print_error(kProgram, loaded.error(), kUsage);
    config = *std::move(loaded);
  }
  spdlog::set_level(spdlog::level::from_str(config.log_level));
  if (checks.self_test) return test_itself(options, config);
  if (!options.replay.empty()) return run_replay(options, config);
  if (options.config.empty()) {
    return print_error(kProgram, {"nothing to do", "", "--config FILE, or --replay PATH"}, kUsage);
  }
  return run_live(options, config);
}

}  // namespace
}  // namespace infuse::daemon

int main(int argc, char** argv) {
  infuse::fix_block_sizes();
  return infuse::daemon::run(argc, argv);
}

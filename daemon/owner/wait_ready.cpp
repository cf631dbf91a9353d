#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/owner/readiness.hpp"

namespace infuse::daemon {
namespace {

struct WaitReadyArguments {
  std::string socket;
  double timeout_s = 30;
};

int run(const WaitReadyArguments& arguments) {
  const auto missing = wait_until_ready(arguments.socket, arguments.timeout_s);
  if (!missing) return kDone;
  std::cerr << fmt::format("infuse wait-ready: not ready after {} s, still waiting for {}\n",
                           arguments.timeout_s, *missing);
  return kFailure;
}

}  // namespace

Command declare_wait_ready(CLI::App& infuse) {
  CLI::App* app =
      infuse.add_subcommand("wait-ready",
                            "wait until every sensor of the running daemon delivers data and no "
                            "level of HEALTH is ERROR or STALE (exit code 1: timeout)");
  const auto arguments = std::make_shared<WaitReadyArguments>();
  app->add_option("--socket", arguments->socket, "socket of the daemon")->type_name("PATH");
  app->add_option("--timeout", arguments->timeout_s, "maximum time to wait, s (30)")
      ->type_name("S")
      ->check(CLI::Range(0.0, 86400.0));
  set_examples(*app, {"infuse wait-ready", "infuse wait-ready --timeout 5 && start-planner"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon

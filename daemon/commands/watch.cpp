#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/commands/client.hpp"
#include "daemon/commands/command.hpp"
#include "daemon/commands/report_text.hpp"

namespace infuse::daemon {
namespace {

struct WatchArguments {
  std::vector<std::string> classes;
  std::string socket;
  bool json = false;
};

int run(const WatchArguments& arguments) {
  auto client = Client::connect(arguments.socket);
  if (!client) return print_error("infuse watch", client.error(), kFailure);
  Json request = {{"op", "watch"}};
  if (!arguments.classes.empty()) request["classes"] = arguments.classes;
  if (auto sent = client->send(request); !sent) {
    return print_error("infuse watch", sent.error(), kFailure);
  }
  while (std::cout) {
    const auto message = client->next(std::nullopt);
    if (!message) return print_error("infuse watch", message.error(), kFailure);
    if (!*message) return kDone;  // the daemon ended
    const std::string name = (*message)->value("class", "");
    if (name == "ERROR") {
      return print_error("infuse watch",
                         {(*message)->value("what", ""), "", (*message)->value("hint", "")},
                         kUsage);
    }
    if (name == "ACK") continue;
    std::cout << (arguments.json ? (*message)->dump() + "\n" : report_text(**message))
              << std::flush;
  }
  return kDone;
}

}  // namespace

Command declare_watch(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand(
      "watch", "print the reports of the running daemon as they arrive, until it ends");
  const auto arguments = std::make_shared<WatchArguments>();
  app->add_option("CLASS", arguments->classes,
                  "DEVICES, SWEEP, FRAME, POSE, CALIBRATION, HEALTH, ALERT, RECORD (default: all)");
  app->add_option("--socket", arguments->socket, "socket of the daemon")->type_name("PATH");
  app->add_flag("--json", arguments->json, "print the reports as JSON, one per line");
  set_examples(*app, {"infuse watch HEALTH ALERT", "infuse watch POSE --json"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon

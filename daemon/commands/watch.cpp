#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/commands/client.hpp"
#include "daemon/commands/command.hpp"
#include "daemon/commands/report_text.hpp"

namespace infuse::daemon {
namespace {

struct Arguments {
  std::vector<std::string> classes;
  std::string socket;
  bool json = false;
};

int run(const Arguments& arguments) {
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
    if (!*message) return kDone;  // the daemon has ended
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
  CLI::App* app =
      infuse.add_subcommand("watch", "what the running daemon reports, as it comes, until it ends");
  const auto arguments = std::make_shared<Arguments>();
  app->add_option("CLASS", arguments->classes, "DEVICES, SWEEP, HEALTH, ALERT; all by default");
  app->add_option("--socket", arguments->socket, "of the daemon")->type_name("PATH");
  app->add_flag("--json", arguments->json, "the reports as they are, a line each");
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon

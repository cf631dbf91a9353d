#include <chrono>
#include <iostream>
#include <memory>
#include <optional>

#include "daemon/command_line/arguments.hpp"
#include "daemon/owner/client.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/owner/report_text.hpp"
#include "daemon/owner/terminal.hpp"
#include "daemon/owner/watch_screen.hpp"

namespace infuse::daemon {
namespace {

struct WatchArguments {
  std::vector<std::string> classes;
  std::string socket;
  bool json = false, tui = false;
};

int run(const WatchArguments& arguments) {
  auto client = Client::connect(arguments.socket);
  if (!client) return print_error("infuse watch", client.error(), kFailure);
  std::optional<Terminal> terminal;
  WatchScreen screen;
  auto drawn = std::chrono::steady_clock::time_point::min();
  if (arguments.tui) {
    if (const auto usable = Terminal::check(); !usable) {
      return print_error("infuse watch", usable.error(), kUsage);
    }
    terminal.emplace();
  }
  const auto draw = [&](const Json& message) {
    constexpr std::chrono::milliseconds kInterval(200);
    screen.add(message);
    const auto now = std::chrono::steady_clock::now();
    if (drawn != std::chrono::steady_clock::time_point::min() && now - drawn < kInterval) return;
    drawn = now;
    const auto [columns, rows] = Terminal::size();
    Terminal::draw(screen.text(columns, rows));
  };
  Json request = {{"op", "watch"}};
  if (!arguments.classes.empty()) request["classes"] = arguments.classes;
  if (auto sent = client->send(request); !sent) {
    return print_error("infuse watch", sent.error(), kFailure);
  }
  while (std::cout) {
    const auto message = client->next(std::nullopt);
    if (!message) {
      terminal.reset();
      return print_error("infuse watch", message.error(), kFailure);
    }
    if (!*message) return kDone;  // the daemon ended
    const std::string name = (*message)->value("class", "");
    if (name == "ERROR") {
      terminal.reset();
      return print_error("infuse watch",
                         {(*message)->value("what", ""), "", (*message)->value("hint", "")},
                         kUsage);
    }
    if (name == "ACK") continue;
    if (terminal) {
      draw(**message);
      continue;
    }
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
  auto* json = app->add_flag("--json", arguments->json, "print the reports as JSON, one per line");
  app->add_flag("--tui", arguments->tui,
                "fill the terminal with alerts, pose, evidence and sensors; Ctrl-C ends it")
      ->excludes(json);
  set_examples(*app, {"infuse watch HEALTH ALERT", "infuse watch --tui"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon

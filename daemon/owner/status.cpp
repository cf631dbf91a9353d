#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/owner/client.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/owner/report_text.hpp"
#include "daemon/protocol/json.hpp"

namespace infuse::daemon {
namespace {

struct StatusArguments {
  std::string socket;
  bool json = false;
};

/// Requests the last report of every class.
Result<std::vector<Json>> poll(Client& client) {
  if (auto sent = client.send({{"op", "poll"}}); !sent) return tl::unexpected(sent.error());
  std::vector<Json> reports;
  while (true) {
    auto message = client.next(std::chrono::seconds(5));
    if (!message) return tl::unexpected(message.error());
    if (!*message) return fail("the daemon ended");
    if ((*message)->value("class", "") == "ACK") return reports;
    reports.push_back(**std::move(message));
  }
}

int run(const StatusArguments& arguments) {
  auto client = Client::connect(arguments.socket);
  if (!client) return print_error("infuse status", client.error(), kFailure);
  const auto reports = poll(*client);
  if (!reports) return print_error("infuse status", reports.error(), kFailure);

  if (!arguments.json) {
    const Json& version = client->version();
    std::cout << fmt::format("infused {}, protocol {}\n", version.value("release", ""),
                             json_text(version.value("protocol", Json())));
    if (version.contains("config_digest")) {
      std::cout << fmt::format("configuration {} {}\n", text_of(version, "config_digest"),
                               text_of(version, "config_version"));
    }
  }
  const DaemonStatus status = daemon_status(*reports);
  if (arguments.json) {
    for (const Json& report : *reports) std::cout << json_text(report) << "\n";
  } else {
    std::cout << status.text;
  }
  return status.level >= Level::kError ? kFailure : kDone;
}

}  // namespace

Command declare_status(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand("status",
                                        "print the state of the running daemon's sensors and "
                                        "calibrations (exit code 1: ERROR or STALE)");
  const auto arguments = std::make_shared<StatusArguments>();
  app->add_option("--socket", arguments->socket, "socket of the daemon")->type_name("PATH");
  app->add_flag("--json", arguments->json, "print the last report of every class, one per line");
  set_examples(*app, {"infuse status", "infuse status --json --socket /tmp/infused.sock"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon

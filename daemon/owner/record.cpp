#include <csignal>
#include <iostream>
#include <map>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/progress_line.hpp"
#include "daemon/owner/client.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/owner/report_text.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kRecordProgram = "infuse record";
constexpr std::chrono::seconds kReportTimeout{10};  // the daemon sends a report every second

struct RecordArguments {
  std::string socket;
  std::string name;
  double seconds = 0;
  uint64_t bytes = 0;
  bool stop = false;
  bool no_wait = false;
  bool json = false;
};

/// Blocks the signals that would end this program, so that they end the recording instead.
void block_interrupts(bool block) {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  const timespec now{};
  if (!block) sigtimedwait(&signals, nullptr, &now);
  sigprocmask(block ? SIG_BLOCK : SIG_UNBLOCK, &signals, nullptr);
}

bool interrupted() {
  sigset_t pending;
  return sigpending(&pending) == 0 &&
         (sigismember(&pending, SIGINT) == 1 || sigismember(&pending, SIGTERM) == 1);
}

/// Waits for the next message of one of these classes.
Result<Json> wait_for_message(Client& client, const std::vector<std::string>& classes) {
  while (true) {
    auto message = client.next(kReportTimeout);
    if (!message) return tl::unexpected(message.error());
    if (!*message) return fail("the daemon ended");
    const std::string name = (*message)->value("class", "");
    for (const std::string& wanted : classes) {
      if (name == wanted) return **std::move(message);
    }
  }
}

/// Sends a request and waits for its answer.
Result<void> send_request(Client& client, const Json& request) {
  if (auto sent = client.send(request); !sent) return sent;
  return wait_for_message(client, {"ACK", "ERROR"})
      .and_then([](const Json& answer) -> Result<void> {
        if (answer.value("class", "") == "ACK") return {};
        return fail(answer.value("what", ""), "", answer.value("hint", ""));
      });
}

Json make_request(const RecordArguments& arguments) {
  Json request = {{"op", "record"}};
  if (arguments.stop) request["on"] = false;
  if (!arguments.name.empty()) request["name"] = arguments.name;
  if (arguments.seconds > 0) request["duration_s"] = arguments.seconds;
  if (arguments.bytes > 0) request["max_bytes"] = arguments.bytes;
  return request;
}

/// Shows the recording's progress until it ends; an interrupt ends it. Returns the last report.
Result<Json> follow(Client& client) {
  ProgressLine line;
  block_interrupts(true);
  while (true) {
    auto report = wait_for_message(client, {"RECORD"});
    if (!report || report->value("state", "") != "recording") return report;
    line.show(std::nullopt, record_text(*report));
    if (!interrupted()) continue;
    block_interrupts(false);  // a second interrupt ends this program at once
    if (auto sent = client.send({{"op", "record"}, {"on", false}}); !sent) {
      return tl::unexpected(sent.error());
    }
  }
}

int run(const RecordArguments& arguments) {
  auto client = Client::connect(arguments.socket);
  if (!client) return print_error(kRecordProgram, client.error(), kFailure);
  const auto begun =
      send_request(*client, {{"op", "watch"}, {"classes", {"RECORD"}}}).and_then([&] {
        return send_request(*client, make_request(arguments));
      });
  if (!begun) return print_error(kRecordProgram, begun.error(), kFailure);
  if (arguments.no_wait && !arguments.stop) return kDone;
  const auto report = follow(*client);
  if (!report) return print_error(kRecordProgram, report.error(), kFailure);
  std::cout << (arguments.json ? report->dump()
                               : report->value("folder", "") + "\n" + record_text(*report))
            << "\n";
  return report->value("state", "") == "failed" ? kFailure : kDone;
}

}  // namespace

Command declare_record(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand(
      "record",
      "let the running daemon record its sensors as a drive, until --for, --max-size, Ctrl-C, or\n"
      "the limits of its configuration; replay the drive with infused --replay");
  const auto arguments = std::make_shared<RecordArguments>();
  app->add_option("-o,--output,name", arguments->name,
                  "name of the drive in the daemon's recording folder (default: the time)")
      ->type_name("NAME");
  const std::map<std::string, double> units = {{"s", 1}, {"min", 60}, {"m", 60}, {"h", 3600}};
  app->add_option("--for", arguments->seconds, "maximum duration: 90, 90s, 5m, 1h")
      ->transform(CLI::AsNumberWithUnit(units))
      ->check(CLI::PositiveNumber)
      ->type_name("TIME");
  app->add_option("--max-size", arguments->bytes, "maximum size: 500M, 2G")
      ->transform(CLI::AsSizeValue(false))
      ->type_name("SIZE");
  app->add_flag("--stop", arguments->stop, "end the running recording");
  app->add_flag("--no-wait", arguments->no_wait, "return as soon as the recording has started");
  app->add_flag("--json", arguments->json, "print the last RECORD report as JSON");
  app->add_option("--socket", arguments->socket, "socket of the daemon")->type_name("PATH");
  set_examples(*app, {"infuse record commute --for 10m", "infuse record --stop"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon

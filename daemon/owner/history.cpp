#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <map>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/history/history_file.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/owner/history_page.hpp"
#include "daemon/owner/report_text.hpp"
#include "drivers/recording/atomic_file.hpp"

namespace infuse::daemon {
namespace {

struct HistoryArguments {
  std::string state = "/var/lib/infuse";
  std::string plot;
  double days = 366;
  bool json = false;
};

std::string text_of_history(const HistoryEntries& entries) {
  constexpr const char* kTime = "{:%Y-%m-%d %H:%M:%S}";
  std::multimap<int64_t, std::string> events;
  for (const Json& alert : entries.alerts) {
    events.emplace(stamp_of(alert), fmt::format("{} {}: {}", text_of(alert, "severity"),
                                                text_of(alert, "id"), text_of(alert, "what")));
  }
  for (const Json& entry : entries.calibrations) {
    events.emplace(stamp_of(entry), fmt::format("calibration of {} in use, {}",
                                                text_of(entry, "device"), text_of(entry, "state")));
  }
  std::string lines;
  for (const auto& [stamp, what] : events) lines += utc_text(stamp, kTime) + " " + what + "\n";
  for (const Json& month : drift_of(entries.calibrations)) {
    const auto r = month["rotation_deg"].get<std::vector<double>>();
    const auto t = month["translation_cm"].get<std::vector<double>>();
    lines += fmt::format(
        "drift of {} until {}: rotation {:+.3f} {:+.3f} {:+.3f} deg, translation {:+.2f} {:+.2f} "
        "{:+.2f} cm\n",
        text_of(month, "device"), text_of(month, "month"), r[0], r[1], r[2], t[0], t[1], t[2]);
  }
  const auto seconds = level_seconds(entries.health);
  uint64_t all = 0;
  for (const auto& [level, count] : seconds) all += count;
  for (const auto& [level, count] : seconds) {
    lines += fmt::format("{}: {:.1f} h, {:.2f} %\n", level, static_cast<double>(count) / 3600,
                         100 * static_cast<double>(count) / static_cast<double>(all));
  }
  if (entries.unreadable > 0) {
    lines += fmt::format("{} lines are damaged or of another release\n", entries.unreadable);
  }
  return lines;
}

int run_history(const HistoryArguments& arguments) {
  const auto lines = read_history(std::filesystem::path(arguments.state) / kHistoryFile);
  if (!lines) return print_error("infuse history", lines.error(), kUnreadable);
  if (lines->empty()) {
    return print_error("infuse history",
                       {"no history yet", arguments.state,
                        "the daemon writes it while it runs; --state names another folder"},
                       kFailure);
  }
  const HistoryEntries entries = sort_entries(*lines, arguments.days);
  if (!arguments.plot.empty()) {
    const std::string page = make_history_page(entries);
    const auto written =
        recording::write_file_atomically(arguments.plot, std::as_bytes(std::span(page)), 0644);
    return written ? kDone : print_error("infuse history", written.error(), kUnreadable);
  }
  if (!arguments.json) {
    std::cout << text_of_history(entries);
    return kDone;
  }
  std::cout << json_text({{"alerts", entries.alerts},
                          {"calibrations", entries.calibrations},
                          {"drift", drift_of(entries.calibrations)},
                          {"health", entries.health},
                          {"unreadable", entries.unreadable}})
            << "\n";
  return kDone;
}

}  // namespace

Command declare_history(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand(
      "history", "print the alerts, calibrations and health of the last months");
  const auto arguments = std::make_shared<HistoryArguments>();
  app->add_option("--state", arguments->state, "state directory of the daemon (/var/lib/infuse)")
      ->type_name("DIR");
  app->add_option("--days", arguments->days, "days before the newest entry (366)")
      ->check(CLI::Range(0.0, 1e6));
  app->add_option("--plot", arguments->plot,
                  "write a page with the cameras' poses over the months, alerts and health")
      ->type_name("FILE.html");
  app->add_flag("--json", arguments->json, "print one JSON object");
  set_examples(*app, {"infuse history --days 30", "infuse history --plot history.html"});
  return {app, [arguments] { return run_history(*arguments); }};
}

}  // namespace infuse::daemon

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include <iostream>
#include <map>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/commands/command.hpp"
#include "daemon/commands/report_text.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/service/history_file.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/rigid_matrix.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::daemon {
namespace {

struct HistoryArguments {
  std::string state = "/var/lib/infuse";
  double days = 366;
  bool json = false;
};

/// The entries of the history, oldest first, and how many lines could not be read.
struct HistoryEntries {
  std::vector<Json> alerts, calibrations, health;
  size_t unreadable = 0;
};

int64_t stamp_of(const Json& entry) { return entry.value("stamp", int64_t{0}); }

std::string utc_text(int64_t ns, const char* form) {
  return fmt::format(fmt::runtime(form), fmt::gmtime(static_cast<std::time_t>(ns / 1'000'000'000)));
}

std::optional<Eigen::Isometry3d> calibration_of(const Json& entry) {
  const auto found = entry.find("T_camera_lidar");
  if (found == entry.end() || !found->is_array() || found->size() != 16) return std::nullopt;
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) {
    const Json& number = (*found)[static_cast<size_t>(i)];
    if (!number.is_number()) return std::nullopt;
    matrix(i / 4, i % 4) = number.get<double>();
  }
  return recording::to_rigid(matrix);
}

/// True if the members that are used have the right types.
bool is_entry(const Json& entry) {
  if (!entry.is_object() || !entry.contains("form") || entry["form"] != kHistoryForm) {
    return false;
  }
  const auto is_text = [&](const char* key) {
    return entry.contains(key) && entry[key].is_string();
  };
  if (!is_text("class") || !entry.contains("stamp") || !entry["stamp"].is_number_integer()) {
    return false;
  }
  if (entry["class"] == "ALERT") return is_text("id") && is_text("severity") && is_text("what");
  if (entry["class"] == "CALIBRATION") {
    return is_text("device") && is_text("state") && calibration_of(entry);
  }
  if (entry["class"] != "HEALTH" || !entry.contains("seconds")) return false;
  for (const Json& seconds : entry["seconds"]) {
    if (!seconds.is_number_unsigned()) return false;
  }
  return true;
}

HistoryEntries sort_entries(const std::vector<std::string>& lines, double days) {
  HistoryEntries entries;
  std::vector<Json> all;
  for (const std::string& line : lines) {
    Json entry = Json::parse(line, nullptr, false);
    if (is_entry(entry)) {
      all.push_back(std::move(entry));
    } else {
      ++entries.unreadable;
    }
  }
  int64_t newest = 0;
  for (const Json& entry : all) newest = std::max(newest, stamp_of(entry));
  for (Json& entry : all) {
    if (static_cast<double>(newest - stamp_of(entry)) * 1e-9 > days * 86'400) continue;
    auto& list = entry["class"] == "ALERT"         ? entries.alerts
                 : entry["class"] == "CALIBRATION" ? entries.calibrations
                                                   : entries.health;
    list.push_back(std::move(entry));
  }
  return entries;
}

/// The last calibration of each camera in each month, relative to its first one: rotation about and
/// translation along the camera's axes.
Json drift_of(const std::vector<Json>& calibrations) {
  std::map<std::string, Eigen::Isometry3d> first;
  std::map<std::pair<std::string, std::string>, Eigen::Isometry3d> last;
  for (const Json& entry : calibrations) {
    const std::string device = text_of(entry, "device");
    const Eigen::Isometry3d T = *calibration_of(entry);
    first.emplace(device, T);
    last[{device, utc_text(stamp_of(entry), "{:%Y-%m}")}] = T;
  }
  Json drift = Json::array();
  for (const auto& [key, T] : last) {
    const geometry::Vector6 moved = geometry::log(T * first.at(key.first).inverse());
    const auto axes = [&](int at, double unit) {
      return Json{moved[at] / unit, moved[at + 1] / unit, moved[at + 2] / unit};
    };
    drift.push_back({{"device", key.first},
                     {"month", key.second},
                     {"rotation_deg", axes(0, kDegree)},
                     {"translation_cm", axes(3, 0.01)}});
  }
  return drift;
}

/// Seconds at each level.
std::map<std::string, uint64_t> level_seconds(const std::vector<Json>& health) {
  std::map<std::string, uint64_t> seconds;
  for (const Json& entry : health) {
    for (const auto& [level, count] : entry["seconds"].items()) {
      seconds[level] += count.get<uint64_t>();
    }
  }
  return seconds;
}

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
  return lines.empty() ? "no history yet\n" : lines;
}

int run_history(const HistoryArguments& arguments) {
  const auto lines = read_history(std::filesystem::path(arguments.state) / kHistoryFile);
  if (!lines) return print_error("infuse history", lines.error(), kUnreadable);
  const HistoryEntries entries = sort_entries(*lines, arguments.days);
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
  app->add_flag("--json", arguments->json, "print one JSON object");
  set_examples(*app, {"infuse history --days 30", "infuse history --json | jq .drift"});
  return {app, [arguments] { return run_history(*arguments); }};
}

}  // namespace infuse::daemon

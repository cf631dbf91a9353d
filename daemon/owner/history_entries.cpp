#include "daemon/owner/history_entries.hpp"

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include "daemon/history/history_file.hpp"
#include "daemon/owner/report_text.hpp"
#include "daemon/protocol/number_json.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/rigid_matrix.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::daemon {
namespace {

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

}  // namespace

int64_t stamp_of(const Json& entry) { return entry.value("stamp", int64_t{0}); }

std::string utc_text(int64_t ns, const char* form) {
  return fmt::format(fmt::runtime(form), fmt::gmtime(static_cast<std::time_t>(ns / 1'000'000'000)));
}

std::optional<Eigen::Isometry3d> calibration_of(const Json& entry) {
  const auto found = entry.find("T_camera_lidar");
  if (found == entry.end()) return std::nullopt;
  const auto numbers = numbers_of(*found, 16);
  return numbers ? recording::to_rigid(*numbers) : std::nullopt;
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

std::map<std::string, uint64_t> level_seconds(const std::vector<Json>& health) {
  std::map<std::string, uint64_t> seconds;
  for (const Json& entry : health) {
    for (const auto& [level, count] : entry["seconds"].items()) {
      seconds[level] += count.get<uint64_t>();
    }
  }
  return seconds;
}

}  // namespace infuse::daemon

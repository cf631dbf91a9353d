#include "daemon/owner/history_page.hpp"

#include <spdlog/fmt/fmt.h>

#include <array>

#include "daemon/owner/report_text.hpp"
#include "daemon/pages/offset_chart.hpp"
#include "daemon/pages/page_style.hpp"
#include "drivers/measurement/angles.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kHistoryStyle =
    "circle{fill:var(--odom)}.bar{stroke:var(--odom)}.band{fill:var(--good);opacity:.25}"
    ".pooled{stroke:var(--good);stroke-width:2}.name{white-space:nowrap}";
constexpr std::array<const char*, 6> kAxisTitles{"rotation x",    "rotation y",    "rotation z",
                                                 "translation x", "translation y", "translation z"};
/// Most poses of a camera that are drawn; others between them are left out.
constexpr size_t kMaxPlottedPoses = 400;
constexpr size_t kMaxAlertRows = 200;
constexpr const char* kDay = "{:%Y-%m-%d}";

/// A pose that was in use from a time on.
struct UsedPose {
  int64_t since = 0;  // ns
  geometry::Vector6 offset;
  std::string state;
};

/// The poses of each camera relative to its first one. A restart writes the pose in use anew: what
/// equals the one before is left out.
std::map<std::string, std::vector<UsedPose>> poses_by_camera(const std::vector<Json>& entries) {
  std::map<std::string, Eigen::Isometry3d> first;
  std::map<std::string, std::vector<UsedPose>> cameras;
  for (const Json& entry : entries) {
    const std::string camera = text_of(entry, "device");
    const Eigen::Isometry3d T = *calibration_of(entry);
    const auto begin = first.emplace(camera, T).first;
    const geometry::Vector6 offset = geometry::log(T * begin->second.inverse());
    std::vector<UsedPose>& poses = cameras[camera];
    if (!poses.empty() && (poses.back().offset - offset).norm() < 1e-9) continue;
    poses.push_back({stamp_of(entry), offset, text_of(entry, "state")});
  }
  return cameras;
}

/// At most `kMaxPlottedPoses` of them, the first and the last among them.
std::vector<UsedPose> thinned(const std::vector<UsedPose>& poses) {
  if (poses.size() <= kMaxPlottedPoses) return poses;
  std::vector<UsedPose> kept;
  for (size_t i = 0; i < kMaxPlottedPoses; ++i) {
    kept.push_back(poses[i * (poses.size() - 1) / (kMaxPlottedPoses - 1)]);
  }
  return kept;
}

std::string camera_charts(const std::string& camera, const std::vector<UsedPose>& all,
                          int64_t newest) {
  const std::vector<UsedPose> poses = thinned(all);
  const int64_t begin = poses.front().since;
  const auto days = [&](int64_t ns) { return static_cast<double>(ns - begin) / 86'400e9; };
  std::string html = fmt::format(
      "<section><h2>{}</h2><p class=note>Pose in use minus the first one, about and along the "
      "camera's axes (z forward, x right, y down); {} changes{}.</p><div class=row>",
      html_text(camera), all.size() - 1,
      all.size() > poses.size() ? fmt::format(", {} of them drawn", poses.size() - 1) : "");
  for (int axis = 0; axis < 6; ++axis) {
    const double unit = axis < 3 ? kDegree : 0.01;
    OffsetChart chart{.title = kAxisTitles[static_cast<size_t>(axis)],
                      .unit = axis < 3 ? "degrees" : "cm",
                      .first_date = utc_text(begin, kDay),
                      .last_date = utc_text(newest, kDay),
                      .days = days(newest)};
    for (size_t i = 0; i < poses.size(); ++i) {
      const double value = poses[i].offset[axis] / unit, from = days(poses[i].since);
      const int64_t end = i + 1 < poses.size() ? poses[i + 1].since : newest;
      chart.points.push_back(
          {from, value, 0, utc_text(poses[i].since, "{:%Y-%m-%d %H:%M}") + ", " + poses[i].state});
      chart.bands.push_back({from, std::max(days(end), from), value, 0});
    }
    html += draw(chart);
  }
  return html + "</div></section>\n";
}

std::string drift_table(const std::vector<Json>& calibrations) {
  std::string html =
      "<section><h2>Drift by month</h2><div class=scroll><table><tr><th>camera<th>month<th "
      "class=number>rotation, degrees<th class=number>translation, cm";
  for (const Json& month : drift_of(calibrations)) {
    const auto r = month["rotation_deg"].get<std::vector<double>>();
    const auto t = month["translation_cm"].get<std::vector<double>>();
    html += fmt::format(
        "<tr><td class=name>{}<td class=name>{}<td class=number>{:+.3f} {:+.3f} {:+.3f}<td "
        "class=number>{:+.2f} {:+.2f} {:+.2f}",
        html_text(text_of(month, "device")), html_text(text_of(month, "month")), r[0], r[1], r[2],
        t[0], t[1], t[2]);
  }
  return html + "</table></div></section>\n";
}

/// An alert's line each hour at most: how many hours had it, and when last.
std::string alert_table(const std::vector<Json>& alerts) {
  struct Row {
    size_t hours = 0;
    int64_t last = 0;
    std::string severity, what;
  };
  std::map<std::string, Row> rows;
  for (const Json& alert : alerts) {
    Row& row = rows[text_of(alert, "id")];
    ++row.hours;
    if (stamp_of(alert) < row.last) continue;
    row = {row.hours, stamp_of(alert), text_of(alert, "severity"), text_of(alert, "what")};
  }
  std::string html =
      "<section><h2>Alerts</h2><div class=scroll><table><tr><th>alert<th>severity<th "
      "class=number>hours with it<th>last<th>what it said then";
  size_t shown = 0;
  for (const auto& [id, row] : rows) {
    if (++shown > kMaxAlertRows) break;
    html += fmt::format("<tr><td class=name>{}<td>{}<td class=number>{}<td class=name>{}<td>{}",
                        html_text(id), html_text(row.severity), row.hours,
                        utc_text(row.last, "{:%Y-%m-%d %H:%M}"), html_text(row.what));
  }
  html += "</table></div>";
  if (rows.size() > kMaxAlertRows) {
    html += fmt::format("<p class=note>{} more are left out</p>", rows.size() - kMaxAlertRows);
  }
  return html + "</section>\n";
}

std::string level_table(const std::vector<Json>& health) {
  std::string html =
      "<section><h2>Health</h2><div class=scroll><table><tr><th>level<th class=number>hours";
  for (const auto& [level, seconds] : level_seconds(health)) {
    html += fmt::format("<tr><td class=name>{}<td class=number>{:.1f}", html_text(level),
                        static_cast<double>(seconds) / 3600);
  }
  return html + "</table></div></section>\n";
}

int64_t newest_stamp(const HistoryEntries& entries) {
  int64_t newest = 0;
  for (const auto* list : {&entries.alerts, &entries.calibrations, &entries.health}) {
    for (const Json& entry : *list) newest = std::max(newest, stamp_of(entry));
  }
  return newest;
}

}  // namespace

std::string make_history_page(const HistoryEntries& entries) {
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=en><head><meta charset=utf-8>\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
      "'unsafe-inline'\">\n<meta name=viewport content=\"width=device-width\">\n"
      "<title>History</title><style>\n{}{}</style></head>\n<body><header><h1>History</h1>"
      "<p class=note>{} alerts, {} calibrations, {} hours{}</p></header><main>\n",
      page_style(), kHistoryStyle, entries.alerts.size(), entries.calibrations.size(),
      entries.health.size(),
      entries.unreadable > 0
          ? fmt::format("; {} lines are damaged or of another release", entries.unreadable)
          : "");
  const int64_t newest = newest_stamp(entries);
  for (const auto& [camera, poses] : poses_by_camera(entries.calibrations)) {
    html += camera_charts(camera, poses, newest);
  }
  if (!entries.calibrations.empty()) html += drift_table(entries.calibrations);
  if (!entries.alerts.empty()) html += alert_table(entries.alerts);
  if (!entries.health.empty()) html += level_table(entries.health);
  return html + "</main></body></html>\n";
}

}  // namespace infuse::daemon

#include "daemon/tools/fleet/fleet_page.hpp"

#include <spdlog/fmt/fmt.h>

#include <array>

#include "daemon/pages/offset_chart.hpp"
#include "daemon/pages/page_style.hpp"
#include "drivers/measurement/angles.hpp"

namespace infuse::daemon {
namespace {

using calibration::PoseVerdict;
using geometry::Vector6;

constexpr const char* kFleetStyle =
    "circle{fill:var(--odom)}.bar{stroke:var(--odom)}.band{fill:var(--good);opacity:.25}"
    ".pooled{stroke:var(--good);stroke-width:2}.change{stroke:var(--bad);stroke-width:2;"
    "stroke-dasharray:2 3}.name{white-space:nowrap}";

/// Names and units of the axes of a chart.
constexpr std::array<const char*, 6> kChartTitles{
    "rotation x", "rotation y", "rotation z", "translation x", "translation y", "translation z"};

const char* class_of(PoseVerdict verdict) {
  switch (verdict) {
    case PoseVerdict::kOnePose:
      return "good";
    case PoseVerdict::kDrift:
      return "bad";
    default:
      return "warn";
  }
}

std::string anchor(size_t vehicle) { return fmt::format("v{}", vehicle + 1); }

double days_after(const CameraSummary& camera, Stamp stamp) {
  return static_cast<double>(stamp.ns() - camera.drives.front().stamp.ns()) / 86'400e9;
}

/// The bands of pooled poses: of the current one from the last step on, or of all.
std::vector<ChartBand> bands_of(const CameraSummary& camera, const Vector6& offset, int axis) {
  const calibration::PoseHistory& history = camera.history;
  if (!history.usable()) return {};
  const double end = days_after(camera, camera.drives.back().stamp);
  double begin = 0;
  if (!history.changes.empty()) {
    // The pose at the end of a ramp holds for its last drive only.
    const auto& last = history.changes.back();
    begin = days_after(camera, camera.drives[last.last].stamp);
  }
  const double unit = axis < 3 ? kDegree : 0.01;
  return {{begin, end, offset(axis) / unit,
           std::sqrt(std::max(history.current.covariance(axis, axis), 0.0)) / unit}};
}

std::string charts_html(const CameraSummary& camera) {
  const Eigen::Isometry3d T_from =
      (camera.T_rig ? *camera.T_rig : camera.history.all.T_camera_lidar).inverse();
  const Vector6 pooled = geometry::log(camera.history.current.T_camera_lidar * T_from);
  std::vector<Vector6> offsets;
  for (const CameraDrive& drive : camera.drives) {
    offsets.push_back(geometry::log(drive.calibration.T_camera_lidar * T_from));
  }
  std::string html = "<div class=row>";
  for (int axis = 0; axis < 6; ++axis) {
    const double unit = axis < 3 ? kDegree : 0.01;
    OffsetChart chart{.title = kChartTitles[static_cast<size_t>(axis)],
                      .unit = axis < 3 ? "degrees" : "cm",
                      .first_date = date_of(camera.drives.front().stamp),
                      .last_date = date_of(camera.drives.back().stamp),
                      .days = days_after(camera, camera.drives.back().stamp),
                      .bands = bands_of(camera, pooled, axis)};
    for (size_t i = 0; i < camera.drives.size(); ++i) {
      const CameraDrive& drive = camera.drives[i];
      const double sigma = std::sqrt(std::max(drive.calibration.covariance(axis, axis), 0.0));
      chart.points.push_back({days_after(camera, drive.stamp), offsets[i](axis) / unit,
                              sigma / unit, drive.drive + ", " + date_of(drive.stamp)});
    }
    for (const auto& change : camera.history.changes) {
      chart.marks.push_back(days_after(camera, camera.drives[change.first].stamp));
    }
    html += draw(chart);
  }
  return html + "</div>";
}

std::string camera_html(const CameraSummary& camera) {
  std::string html = fmt::format("<h3>{} against {}</h3><p class={}>{}</p>",
                                 html_text(camera.camera), html_text(camera.lidar),
                                 class_of(camera.history.verdict), html_text(describe(camera)));
  if (!camera.drives.empty()) {
    html += fmt::format(
        "<p class=note>Offsets from {}, about and along the camera's axes (z forward, x right, y "
        "down), of {} drives{}. Bars and band: 95 %, of what differs between drives.</p>",
        camera.T_rig ? "the rig's pose" : "the pooled pose", camera.drives.size(),
        camera.left_out > 0 ? fmt::format("; {} older ones are left out", camera.left_out) : "");
    html += charts_html(camera);
  }
  if (!camera.unusable.empty()) {
    html += "<div class=scroll><table><tr><th>not used<th>reason";
    for (const CameraDrive& drive : camera.unusable) {
      html += fmt::format("<tr><td class=name>{}<td>{}", html_text(drive.drive),
                          html_text(drive.calibration.reason));
    }
    html += "</table></div>";
  }
  return html;
}

std::string verdict_text(const VehicleSummary& vehicle) {
  std::string text = name_of(vehicle.verdict());
  std::replace(text.begin(), text.end(), '_', ' ');
  if (vehicle.differs_from_rig()) text += ", off the rig";
  return text;
}

std::string vehicles_html(const FleetSummary& fleet) {
  std::string html =
      "<section><h2>Vehicles</h2><div class=scroll><table><tr><th>vehicle<th>verdict<th "
      "class=number>drives<th class=number>failed<th class=number>driven<th "
      "class=number>alerts<th>cameras";
  for (size_t v = 0; v < fleet.vehicles.size(); ++v) {
    const VehicleSummary& vehicle = fleet.vehicles[v];
    std::string cameras;
    for (const CameraSummary& camera : vehicle.cameras) {
      cameras += fmt::format("{}{}: {}", cameras.empty() ? "" : "<br>", html_text(camera.camera),
                             html_text(describe(camera)));
    }
    const char* mark = class_of(vehicle.verdict());
    if (vehicle.verdict() == PoseVerdict::kOnePose && vehicle.differs_from_rig()) mark = "warn";
    html += fmt::format(
        "<tr><td class=name><a href=\"#{}\">{}</a><td class=\"name {}\">{}<td class=number>{}<td "
        "class=number>{}<td "
        "class=number>{:.1f} min<td class=number>{}<td>{}",
        anchor(v), html_text(vehicle.name), mark, verdict_text(vehicle), vehicle.drives,
        vehicle.failed, vehicle.driven_s / 60, vehicle.alerts, cameras);
  }
  return html + "</table></div></section>";
}

std::string failed_html(const FleetSummary& fleet) {
  if (fleet.failed.empty()) return {};
  std::string html =
      "<section><h2>Failed drives</h2><div "
      "class=scroll><table><tr><th>vehicle<th>drive<th>step<th>reason";
  for (const FailedDrive& failed : fleet.failed) {
    html += fmt::format("<tr><td class=name>{}<td class=name>{}<td class=name>{}<td class=bad>{}",
                        html_text(failed.vehicle), html_text(failed.drive),
                        html_text(failed.failure.step), html_text(failed.failure.what));
  }
  return html + "</table></div></section>";
}

}  // namespace

std::string make_fleet_page(const FleetSummary& fleet) {
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=en><head><meta charset=utf-8>\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
      "'unsafe-inline'\">\n<meta name=viewport content=\"width=device-width\">\n"
      "<title>The fleet</title><style>\n{}{}</style></head>\n<body><header><h1>The fleet</h1>"
      "<p class=note>{} drives of {} vehicles</p></header><main>\n",
      page_style(), kFleetStyle, fleet.drives, fleet.vehicles.size());
  html += vehicles_html(fleet) + "\n" + failed_html(fleet) + "\n";
  for (size_t v = 0; v < fleet.vehicles.size(); ++v) {
    html +=
        fmt::format("<section id={}><h2>{}</h2>\n", anchor(v), html_text(fleet.vehicles[v].name));
    for (const CameraSummary& camera : fleet.vehicles[v].cameras)
      html += camera_html(camera) + "\n";
    html += "</section>\n";
  }
  return html + "</main></body></html>\n";
}

}  // namespace infuse::daemon

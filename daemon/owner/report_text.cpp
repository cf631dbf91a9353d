#include "daemon/owner/report_text.hpp"

#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "daemon/protocol/names.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/text/printable.hpp"

namespace infuse::daemon {
namespace {

/// "12:03:55.120" UTC.
std::string time_text(const Json& message) {
  const auto ns = message.value("stamp", int64_t{0});
  const auto seconds = static_cast<std::time_t>(ns / 1'000'000'000);
  return fmt::format("{:%H:%M:%S}.{:03}", fmt::gmtime(seconds), ns / 1'000'000 % 1000);
}

std::string device_line(const Json& device) {
  return fmt::format("  {}: {} {} on {} ({})\n", text_of(device, "device"), text_of(device, "kind"),
                     text_of(device, "model"), text_of(device, "endpoint"),
                     text_of(device, "model_reason"));
}

std::string findings_text(const Json& sensor) {
  std::string lines;
  for (const Json& finding : sensor.value("findings", Json::array())) {
    const std::string since =
        finding.contains("since") ? ", since " + utc_text(finding, "since") : "";
    lines += fmt::format("        {}{} ({})\n", text_of(finding, "what"), since,
                         text_of(finding, "advice"));
  }
  return lines;
}

/// The maps in use; what is kept on disks; and what waits for the broker.
std::string stores_text(const Json& host) {
  std::string lines;
  for (const Json& map : host.value("maps", Json::array())) {
    const bool current = map.value("current", true);
    lines += fmt::format("  {:<5} {} {} in use{}\n", current ? "OK" : "WARN", text_of(map, "map"),
                         text_of(map, "digest"),
                         current ? "" : "; the new one is not: " + text_of(map, "problem"));
  }
  for (const Json& store : host.value("stores", Json::array())) {
    const bool writable = store.value("writable", true);
    lines += fmt::format("  {:<5} {} on disk: {}", writable ? "OK" : "WARN",
                         text_of(store, "store"), writable ? "" : text_of(store, "problem") + ", ");
    lines += store.contains("free_bytes")
                 ? fmt::format("{:.1f} GB free\n", store.value("free_bytes", 0.0) * 1e-9)
                 : "free space unknown\n";
  }
  for (const Json& queue : host.value("queues", Json::array())) {
    if (text_of(queue, "queue") != "mqtt_kib") continue;
    lines += fmt::format("        {} KiB wait for the broker, {} reports dropped\n",
                         queue.value("depth", uint64_t{0}), queue.value("lost", uint64_t{0}));
  }
  return lines;
}

/// Places of the street map that look alike: ", at one of 2 places: 60, 40 %".
std::string alike_text(const Json& map) {
  const Json places = map.value("places", Json::array());
  if (places.empty()) return "";
  std::string text;
  for (const Json& place : places) {
    text +=
        fmt::format("{} {:.0f}", text.empty() ? "" : ",", 100 * place.value("probability", 0.0));
  }
  return fmt::format(", at one of {} places:{} %", places.size(), text);
}

/// State of the tracker and why it is not TRACKING; empty but for a pose on the street map.
std::string state_text(const Json& pose) {
  const std::string state = text_of(pose, "state"), doubt = text_of(pose, "doubt");
  if (state.empty()) return {};
  return ", " + state + (doubt.empty() || !pose.value("usable", false) ? "" : ": " + doubt);
}

std::string speed_text(const Json& message) {
  return fmt::format("{:.1f} m/s", message.value("speed", 0.0));
}

std::string sweep_text(const Json& message) {
  return fmt::format(
      "{} SWEEP {} #{}: {} returns in {:.1f} ms, mean range {:.1f} m, {} packets lost, {}\n",
      time_text(message), text_of(message, "device"), message.value("sequence", uint64_t{0}),
      message.value("returns", uint64_t{0}), message.value("span_s", 0.0) * 1e3,
      message.value("mean_range", 0.0), message.value("lost_packets", uint64_t{0}),
      message.value("deskewed", false)
          ? fmt::format("deskewed ({:.2f} m, {:.1f}°)", message.value("travelled", 0.0),
                        message.value("turned_deg", 0.0))
          : "not deskewed: " + text_of(message, "deskew_reason"));
}

std::string frame_text(const Json& message) {
  return fmt::format(
      "{} FRAME {} #{}: {} × {}, {}\n", time_text(message), text_of(message, "device"),
      message.value("sequence", uint64_t{0}), message.value("width", 0), message.value("height", 0),
      message.contains("reason")
          ? text_of(message, "reason")
          : fmt::format("{} points of sweep #{} in view", message.value("points_in_view", 0),
                        message.value("sweep", uint64_t{0})));
}

std::string pose_text(const Json& message) {
  const auto T = message.value("T_frame_vehicle", std::vector<double>(16));
  const std::string state = state_text(message);
  return fmt::format("{} POSE in {}: ({:.2f}, {:.2f}) m, heading {:.1f}°{}\n", time_text(message),
                     text_of(message, "frame"), T[3], T[7], std::atan2(T[4], T[0]) / kDegree,
                     message.value("usable", false)
                         ? ", " + speed_text(message) + state
                         : state + ", not usable: " + text_of(message, "reason"));
}

/// True for a camera that is silent, or cannot be opened.
bool gives_no_images(const Json& health, const std::string& camera) {
  for (const Json& stream : health.value("streams", Json::array())) {
    if (text_of(stream, "device") != camera) continue;
    for (const Json& finding : stream.value("findings", Json::array())) {
      const std::string id = text_of(finding, "id");
      if (id == "silent" || id == "unavailable") return true;
    }
  }
  return false;
}

}  // namespace

std::string text_of(const Json& object, const char* key) {
  return text::printable(object.value(key, ""));
}

std::string health_text(const Json& health) {
  std::string lines = findings_text(health);
  for (const Json& sensor : health.value("sensors", Json::array())) {
    const Json losses = sensor.value("losses", Json::object());
    lines += fmt::format("  {:<5} {}: {:.1f} sweeps/s, {:.0f} packets/s, {} lost{}\n",
                         text_of(sensor, "level"), text_of(sensor, "device"),
                         sensor.value("sweeps_hz", 0.0), sensor.value("packets_hz", 0.0),
                         losses.value("network", uint64_t{0}) + losses.value("kernel", uint64_t{0}),
                         sensor.contains("sender") ? ", from " + text_of(sensor, "sender") : "");
    lines += findings_text(sensor);
  }
  for (const Json& stream : health.value("streams", Json::array())) {
    lines += fmt::format("  {:<5} {}: {:.1f}/s, {} used, {} rejected\n", text_of(stream, "level"),
                         text_of(stream, "device"), stream.value("received_hz", 0.0),
                         stream.value("used", uint64_t{0}), stream.value("refused", uint64_t{0}));
    lines += findings_text(stream);
  }
  if (health.contains("odometry")) {
    const Json& odometry = health["odometry"];
    lines += fmt::format("  {:<5} odometry: {}\n", text_of(odometry, "level"),
                         odometry.value("usable", false)
                             ? speed_text(odometry) + ", trusted"
                             : "not trusted: " + text_of(odometry, "reason"));
    lines += findings_text(odometry);
  }
  if (health.contains("streetmap")) {
    const Json& map = health["streetmap"];
    const std::string state = text_of(map, "state"), reason = text_of(map, "reason");
    const std::string sigma =
        state == "LOST" ? "" : fmt::format(", ± {:.1f} m", map.value("sigma", 0.0));
    const std::string gnss = map.contains("gnss_offset_sigma")
                                 ? fmt::format(", GNSS {:.1f} ± {:.1f} m off",
                                               std::hypot(map.value("gnss_offset_east", 0.0),
                                                          map.value("gnss_offset_north", 0.0)),
                                               map.value("gnss_offset_sigma", 0.0))
                                 : "";
    const auto places = map.value("hypotheses", uint64_t{0});
    const std::string search = places > 0 ? fmt::format(", searching: {} places", places) : "";
    lines += fmt::format("  {:<5} street map: {}{}{}{}{}{}\n", text_of(map, "level"), state, sigma,
                         gnss, search, alike_text(map), reason.empty() ? "" : ": " + reason);
    lines += findings_text(map);
  }
  if (health.contains("map")) {
    const Json& map = health["map"];
    const std::string state = text_of(map, "state"), reason = text_of(map, "reason");
    const std::string sigma =
        state == "LOST" ? "" : fmt::format(", ± {:.2f} m", map.value("sigma", 0.0));
    lines += fmt::format("  {:<5} map: {}{}{}\n", text_of(map, "level"), state, sigma,
                         reason.empty() ? "" : ": " + reason);
    lines += findings_text(map);
  }
  for (const Json& calibration : health.value("calibrations", Json::array())) {
    const std::string camera = text_of(calibration, "device");
    const bool blind = gives_no_images(health, camera);
    // A calibration that nothing watches is not OK; what was found before still holds.
    const std::string level = text_of(calibration, "level");
    lines += fmt::format("  {:<5} calibration of {}{}\n", blind && level == "OK" ? "-" : level,
                         camera, blind ? ": not monitored, no images" : "");
    lines += findings_text(calibration);
  }
  if (health.contains("host")) lines += stores_text(health["host"]);
  return lines;
}

std::string utc_text(const Json& object, const char* key) {
  const auto seconds = static_cast<std::time_t>(object.value(key, int64_t{0}) / 1'000'000'000);
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(seconds));
}

Level level_of(const Json& object, const char* key) {
  const std::string name = text_of(object, key);
  for (const Level level : {Level::kWarn, Level::kError, Level::kStale}) {
    if (name == name_of(level)) return level;
  }
  return Level::kOk;
}

std::vector<NamedFinding> findings_of(const Json& health) {
  std::vector<NamedFinding> list;
  const auto append = [&](const std::string& device, const Json& part, bool calibration = false) {
    for (const Json& finding : part.value("findings", Json::array())) {
      list.push_back({device, finding, calibration});
    }
  };
  append(kDaemonDevice, health);
  for (const char* kind : {"sensors", "streams"}) {
    for (const Json& sensor : health.value(kind, Json::array())) {
      append(text_of(sensor, "device"), sensor);
    }
  }
  for (const char* stage : {"odometry", "streetmap", "map"}) {
    if (health.contains(stage)) append(stage, health[stage]);
  }
  for (const Json& calibration : health.value("calibrations", Json::array())) {
    append(text_of(calibration, "device"), calibration, true);
  }
  return list;
}

DaemonStatus daemon_status(const std::vector<Json>& reports) {
  DaemonStatus status;
  std::string health = "no health report yet\n";
  for (const Json& report : reports) {
    if (text_of(report, "class") == "RECORD" && text_of(report, "state") != "ended") {
      status.text += report_text(report);
    }
    if (text_of(report, "class") != "HEALTH") continue;
    status.level = level_of(report, "level");
    health = report_text(report);
  }
  status.text += health;
  return status;
}

std::string record_text(const Json& record) {
  std::string line = fmt::format(
      "{} {}: {:.1f} s, {:.1f} MB; {} datagrams, {} CAN frames, {} images, {} GNSS fixes",
      text_of(record, "name"), text_of(record, "state"), record.value("duration_s", 0.0),
      record.value("bytes", 0.0) * 1e-6, record.value("datagrams", uint64_t{0}),
      record.value("frames", uint64_t{0}), record.value("images", uint64_t{0}),
      record.value("fixes", uint64_t{0}));
  if (const auto lost = record.value("lost", uint64_t{0}); lost > 0) {
    line += fmt::format("; {} lost: the disk or the processor is too slow", lost);
  }
  if (record.contains("reason")) line += "; " + text_of(record, "reason");
  return line;
}

std::string report_text(const Json& message) {
  const std::string name = text_of(message, "class");
  if (name == "SWEEP") return sweep_text(message);
  if (name == "FRAME") return frame_text(message);
  if (name == "POSE") return pose_text(message);
  if (name == "CALIBRATION") {
    return fmt::format("{} CALIBRATION {} {} ({} evaluations, {} scenes)\n", time_text(message),
                       text_of(message, "device"), text_of(message, "state"),
                       message.value("evaluations", uint64_t{0}),
                       message.value("scenes", uint64_t{0}));
  }
  if (name == "HEALTH") {
    return fmt::format("{} HEALTH {} (running for {:.0f} s)\n{}", time_text(message),
                       text_of(message, "level"), message.value("drive_s", 0.0),
                       health_text(message));
  }
  if (name == "ALERT") {
    return fmt::format("{} ALERT {} {} {}: {} ({})\n", time_text(message),
                       text_of(message, "severity"), text_of(message, "id"),
                       text_of(message, "state"), text_of(message, "what"),
                       text_of(message, "advice"));
  }
  if (name == "RECORD") return time_text(message) + " RECORD " + record_text(message) + "\n";
  if (name == "LOST") {
    return fmt::format("{} LOST {} reports: this client reads too slowly\n", time_text(message),
                       message.value("reports", uint64_t{0}));
  }
  if (name == "DEVICES") {
    std::string lines = time_text(message) + " DEVICES\n";
    for (const Json& device : message.value("devices", Json::array())) lines += device_line(device);
    return lines;
  }
  return json_text(message) + "\n";
}

}  // namespace infuse::daemon

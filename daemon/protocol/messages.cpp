#include "daemon/protocol/messages.hpp"

#include <cmath>
#include <numbers>

#include "daemon/protocol/counters_json.hpp"

namespace infuse::daemon {
namespace {

/// Text from files may not be UTF-8; it is mended rather than thrown about.
std::string line(const Json& message) {
  return message.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json report(const char* name, Stamp stamp) { return {{"class", name}, {"stamp", stamp.ns()}}; }

void add_known(Json& to, const char* key, double value) {
  if (std::isfinite(value)) to[key] = value;
}

Json finding_json(const Finding& finding) {
  return {{"id", finding.id},
          {"level", name_of(finding.level)},
          {"since", finding.since.ns()},
          {"what", finding.what},
          {"advice", finding.advice}};
}

Json sensor_json(const Device& device, const SensorStatus& status) {
  const SensorCounters& c = status.counters;
  Json json = {{"device", device.name},
               {"level", name_of(status.level)},
               {"packets_hz", rounded(status.packets_hz)},
               {"sweeps_hz", rounded(status.sweeps_hz)},
               {"returns_hz", rounded(status.returns_hz)},
               {"packets", c.packets},
               {"position_packets", c.position_packets},
               {"sweeps", c.sweeps},
               {"returns", c.returns},
               {"losses", losses_json(c)},
               {"out_of_order", c.out_of_order},
               {"wrong_model", c.wrong_model},
               {"clock_jumps", c.clock_jumps}};
  if (c.packets > 0) {
    json["last_packet"] = c.last_packet.ns();
    json["clock"] = to_json(c.clock);
  }
  json["findings"] = Json::array();
  for (const Finding& finding : status.findings) json["findings"].push_back(finding_json(finding));
  return json;
}

Json host_json(const HostFigures& host) {
  Json stages = Json::array();
  for (const StageFigures& stage : host.stages) {
    stages.push_back({{"stage", stage.name},
                      {"count", stage.latency.count},
                      {"latency_ms", latency_ms_json(stage.latency)},
                      {"deadline_misses", stage.deadline_misses}});
  }
  Json queues = Json::array();
  for (const QueueFigures& queue : host.queues) {
    queues.push_back({{"queue", queue.name}, {"depth", queue.depth}, {"capacity", queue.capacity}});
  }
  return {{"cpu_s", rounded(host.cpu_s)}, {"stages", stages}, {"queues", queues}};
}

}  // namespace

std::string version_message(std::string_view release, std::string_view session) {
  return line(Json{{"class", "VERSION"},
                   {"release", release},
                   {"protocol", kProtocolVersion},
                   {"session", session}});
}

std::string devices_message(Stamp stamp, std::span<const Device> devices) {
  Json message = report("DEVICES", stamp);
  message["devices"] = Json::array();
  for (const Device& device : devices) {
    Json json = {{"device", device.name},
                 {"kind", device.kind},
                 {"model", device.model},
                 {"model_reason", device.model_reason},
                 {"endpoint", device.endpoint}};
    if (device.activated) json["activated"] = device.activated->ns();
    message["devices"].push_back(std::move(json));
  }
  return line(message);
}

std::string sweep_message(const SweepReport& sweep, std::span<const Device> devices) {
  Json message = report("SWEEP", sweep.stamp);
  message["device"] = devices[sweep.device].name;
  message["sequence"] = sweep.sequence;
  message["span_s"] = to_seconds(sweep.span);
  message["returns"] = sweep.returns;
  message["columns"] = sweep.columns;
  message["rings"] = sweep.rings;
  message["lost_packets"] = sweep.lost_packets;
  message["gaps"] = sweep.gaps;
  message["gap_deg"] = rounded(sweep.gap_angle * 180 / std::numbers::pi);
  add_known(message, "mean_range", rounded(sweep.mean_range));
  add_known(message, "max_range", rounded(sweep.max_range));
  add_known(message, "mean_reflectivity", rounded(sweep.mean_reflectivity));
  message["has_times"] = sweep.has_times;
  message["clock_trusted"] = sweep.clock_trusted;
  return line(message);
}

std::string health_message(const HealthReport& health, std::span<const Device> devices,
                           const HostFigures* host) {
  Json message = report("HEALTH", health.stamp);
  message["drive_s"] = rounded(to_seconds(health.drive));
  Level worst = Level::kOk;
  for (const SensorStatus* sensor : health.sensors) worst = std::max(worst, sensor->level);
  message["level"] = name_of(worst);
  message["sensors"] = Json::array();
  for (size_t i = 0; i < health.sensors.size(); ++i) {
    message["sensors"].push_back(sensor_json(devices[i], *health.sensors[i]));
  }
  if (host != nullptr) message["host"] = host_json(*host);
  return line(message);
}

std::string alert_message(const AlertReport& alert) {
  Json message = report("ALERT", alert.stamp);
  message["id"] = alert.device + "." + alert.finding.id;
  message["device"] = alert.device;
  message["severity"] = name_of(alert.finding.level);
  message["state"] = alert.raised ? "raised" : "cleared";
  message["since"] = alert.finding.since.ns();
  message["what"] = alert.finding.what;
  message["advice"] = alert.finding.advice;
  return line(message);
}

std::string lost_message(Stamp stamp, uint64_t reports) {
  Json message = report("LOST", stamp);
  message["reports"] = reports;
  return line(message);
}

std::string ack_message(std::string_view op) { return line(Json{{"class", "ACK"}, {"op", op}}); }

std::string error_message(std::string_view op, std::string_view what, std::string_view hint) {
  Json message = {{"class", "ERROR"}};
  if (!op.empty()) message["op"] = op;
  message["what"] = what;
  if (!hint.empty()) message["hint"] = hint;
  return line(message);
}

}  // namespace infuse::daemon

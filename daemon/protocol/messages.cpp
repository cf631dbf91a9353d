#include "daemon/protocol/messages.hpp"

#include <cmath>

#include "daemon/protocol/counters_json.hpp"
#include "drivers/measurement/angles.hpp"

namespace infuse::daemon {
namespace {

/// Text from files may not be UTF-8; it is mended rather than thrown about.
std::string line(const Json& message) {
  return message.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json report(const char* name, Stamp stamp) { return {{"class", name}, {"stamp", stamp.ns()}}; }

void add_if_finite(Json& to, const char* key, double value) {
  if (std::isfinite(value)) to[key] = value;
}

/// A matrix as a list of numbers by row.
template <class Matrix>
Json by_row(const Matrix& matrix) {
  Json numbers = Json::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      numbers.push_back(matrix(row, column));
    }
  }
  return numbers;
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

Json stream_json(const Device& device, const StreamStatus& status) {
  const StreamCounters& c = status.counters;
  Json json = {{"device", device.name},          {"kind", device.kind},
               {"level", name_of(status.level)}, {"received_hz", rounded(status.received_hz)},
               {"received", c.received},         {"used", c.used},
               {"refused", c.refused},           {"lost", c.lost},
               {"out_of_order", c.out_of_order}};
  if (c.received > 0) json["last"] = c.last.ns();
  if (*c.source.stamp_source != '\0') json["stamp_source"] = c.source.stamp_source;
  json["findings"] = Json::array();
  for (const Finding& finding : status.findings) json["findings"].push_back(finding_json(finding));
  return json;
}

Json odometry_json(const OdometryStatus& odometry, const Conditions& conditions) {
  Json json = {{"level", name_of(conditions.level())},
               {"usable", odometry.usable()},
               {"speed", rounded(odometry.speed)},
               {"yaw_rate", rounded(odometry.yaw_rate)},
               {"standing", odometry.standing},
               {"wheel_scale", odometry.wheel_scale},
               {"wheel_scale_sigma", odometry.wheel_scale_sigma},
               {"yaw_rate_bias", odometry.yaw_rate_bias},
               {"yaw_rate_bias_sigma", odometry.yaw_rate_bias_sigma},
               {"gyro_bias", odometry.gyro_bias},
               {"gyro_bias_sigma", odometry.gyro_bias_sigma},
               {"late", odometry.late},
               {"outliers", odometry.outliers},
               {"senseless", odometry.invalid_samples},
               {"sweeps_not_deskewed", odometry.not_deskewed}};
  if (!odometry.usable()) json["reason"] = odometry.reason;
  json["findings"] = Json::array();
  for (const Finding& finding : conditions.findings()) {
    json["findings"].push_back(finding_json(finding));
  }
  return json;
}

Json streetmap_json(const StreetMapStatus& figures, const Conditions& conditions) {
  Json json = {{"level", name_of(conditions.level())}, {"state", figures.state},
               {"p_value", rounded(figures.p_value)},  {"entropy", rounded(figures.entropy)},
               {"particles", figures.particles},       {"updates", figures.updates}};
  if (*figures.reason != '\0') json["reason"] = figures.reason;
  json["findings"] = Json::array();
  for (const Finding& finding : conditions.findings()) {
    json["findings"].push_back(finding_json(finding));
  }
  return json;
}

Json host_json(const HostStats& host) {
  Json stages = Json::array();
  for (const StageStats& stage : host.stages) {
    stages.push_back({{"stage", stage.name},
                      {"count", stage.latency.count},
                      {"latency_ms", latency_ms_json(stage.latency)},
                      {"deadline_misses", stage.deadline_misses}});
  }
  Json queues = Json::array();
  for (const QueueStats& queue : host.queues) {
    queues.push_back({{"queue", queue.name},
                      {"depth", queue.depth},
                      {"capacity", queue.capacity},
                      {"lost", queue.lost}});
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
  message["gap_deg"] = rounded(sweep.gap_angle / kDegree);
  add_if_finite(message, "mean_range", rounded(sweep.mean_range));
  add_if_finite(message, "max_range", rounded(sweep.max_range));
  add_if_finite(message, "mean_reflectivity", rounded(sweep.mean_reflectivity));
  message["has_times"] = sweep.has_times;
  message["clock_trusted"] = sweep.clock_trusted;
  message["deskewed"] = *sweep.deskew_reason == '\0';
  if (*sweep.deskew_reason != '\0') {
    message["deskew_reason"] = sweep.deskew_reason;
  } else {
    message["travelled"] = rounded(sweep.travelled);
    message["turned_deg"] = rounded(sweep.turned / kDegree);
  }
  return line(message);
}

std::string frame_message(const FrameReport& frame, std::span<const Device> cameras) {
  Json message = report("FRAME", frame.stamp);
  message["device"] = cameras[frame.camera].name;
  message["sequence"] = frame.sequence;
  message["width"] = frame.width;
  message["height"] = frame.height;
  message["mean_brightness"] = rounded(frame.mean_brightness);
  message["dark"] = rounded(frame.dark);
  message["bright"] = rounded(frame.bright);
  if (*frame.reason != '\0') {
    message["reason"] = frame.reason;
    return line(message);
  }
  message["sweep"] = frame.sweep;
  message["sweep_offset_s"] = to_seconds(frame.sweep_offset);
  message["points_in_view"] = frame.points_in_view;
  message["deskewed"] = *frame.deskew_reason == '\0';
  if (*frame.deskew_reason != '\0') message["deskew_reason"] = frame.deskew_reason;
  return line(message);
}

std::string pose_message(const PoseReport& pose) {
  Json message = report("POSE", pose.stamp);
  message["frame"] = pose.frame;
  message["usable"] = pose.usable();
  if (!pose.usable()) message["reason"] = pose.reason;
  message["T_frame_vehicle"] = by_row(pose.T_frame_vehicle.matrix());
  message["covariance"] = by_row(pose.covariance);
  message["speed"] = rounded(pose.speed);
  message["yaw_rate"] = rounded(pose.yaw_rate);
  if (*pose.state != '\0') {
    message["state"] = pose.state;
    message["p_value"] = rounded(pose.p_value);
    message["entropy"] = rounded(pose.entropy);
  }
  return line(message);
}

std::string calibration_message(const CalibrationReport& calibration) {
  Json message = report("CALIBRATION", calibration.stamp);
  message["device"] = calibration.camera;
  message["state"] = calibration.state;
  message["since"] = calibration.since.ns();
  message["policy"] = calibration.policy;
  message["frozen"] = calibration.frozen;
  message["T_camera_lidar"] = by_row(calibration.T_camera_lidar.matrix());
  message["evaluations"] = calibration.evaluations;
  message["scenes"] = calibration.scenes;
  if (*calibration.axis != '\0') {
    message["evidence"] = {{"axis", calibration.axis},
                           {"nats", rounded(calibration.evidence)},
                           {"threshold_nats", rounded(calibration.evidence_threshold)}};
    message["offset"] = by_row(calibration.offset);
    message["offset_sigma"] = by_row(calibration.offset_sigma.unaryExpr(
        [](double sigma) { return std::isfinite(sigma) ? sigma : 1e9; }));
    message["delay_s"] = rounded(calibration.delay);
    if (*calibration.delay_ambiguous_axis != '\0')
      message["delay_ambiguous_axis"] = calibration.delay_ambiguous_axis;
    message["dependence_nats"] = calibration.dependence;
  }
  if (*calibration.fault != '\0') message["camera_fault"] = calibration.fault;
  if (calibration.has_estimate) {
    Json estimate = {{"T_camera_lidar", by_row(calibration.T_camera_lidar_estimate.matrix())},
                     {"covariance", by_row(calibration.covariance)},
                     {"mahalanobis_distance", rounded(calibration.mahalanobis_distance)},
                     {"scenes", calibration.estimate_scenes},
                     {"usable", calibration.estimate_reason.empty()}};
    if (!calibration.estimate_reason.empty()) estimate["reason"] = calibration.estimate_reason;
    message["estimate"] = std::move(estimate);
  }
  message["history"] = Json::array();
  for (const CalibrationChange& change : calibration.history) {
    message["history"].push_back({{"stamp", change.stamp.ns()},
                                  {"state", change.state},
                                  {"what", change.what},
                                  {"T_camera_lidar", by_row(change.T_camera_lidar.matrix())}});
  }
  return line(message);
}

std::string health_message(const HealthReport& health, std::span<const Device> devices,
                           const HostStats* host) {
  Json message = report("HEALTH", health.stamp);
  message["drive_s"] = rounded(to_seconds(health.drive));
  Level worst = Level::kOk;
  for (const SensorStatus* sensor : health.sensors) worst = std::max(worst, sensor->level);
  for (const StreamStatus* stream : health.streams) worst = std::max(worst, stream->level);
  if (health.odometry != nullptr) worst = std::max(worst, health.odometry_conditions->level());
  if (health.streetmap != nullptr) worst = std::max(worst, health.streetmap_conditions->level());
  message["level"] = name_of(worst);
  message["sensors"] = Json::array();
  for (size_t i = 0; i < health.sensors.size(); ++i) {
    message["sensors"].push_back(sensor_json(devices[i], *health.sensors[i]));
  }
  message["streams"] = Json::array();
  for (size_t i = 0; i < health.streams.size(); ++i) {
    message["streams"].push_back(
        stream_json(devices[health.sensors.size() + i], *health.streams[i]));
  }
  if (health.odometry != nullptr) {
    message["odom"] = odometry_json(*health.odometry, *health.odometry_conditions);
  }
  if (health.streetmap != nullptr) {
    message["streetmap"] = streetmap_json(*health.streetmap, *health.streetmap_conditions);
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

std::string record_message(const RecordReport& record) {
  Json message = report("RECORD", record.stamp);
  message["state"] = record.failed ? "failed" : record.ended ? "ended" : "recording";
  message["name"] = record.name;
  message["folder"] = record.folder;
  message["cause"] = record.cause;
  message["since"] = record.since.ns();
  message["duration_s"] = rounded(to_seconds(record.duration));
  message["bytes"] = record.bytes;
  message["drives"] = record.drives;
  message["datagrams"] = record.datagrams;
  message["frames"] = record.frames;
  message["images"] = record.images;
  message["fixes"] = record.fixes;
  message["lost"] = record.lost;
  if (!record.reason.empty()) message["reason"] = record.reason;
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

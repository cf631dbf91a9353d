#pragma once

#include "daemon/protocol/field.hpp"
#include "daemon/protocol/names.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/measurement/ipv4_address.hpp"

namespace infuse::daemon {

// The one description of every message: names, order, meaning and units of its fields, and the
// metrics that export them. README.md says how a field is added.

/// Major and minor version. A client of one major version can read all messages of that version.
inline constexpr std::array<int, 2> kProtocolVersion = {2, 0};

inline constexpr const char* kStampText = "ns since the Unix epoch; drive time in a replay";
inline constexpr const char* kCovarianceText =
    "by row; rx ry rz tx ty tz, rad and m, left perturbation in the target frame";

/// Converts radians to degrees, for the wire.
inline double degrees(double radians) { return radians / kDegree; }

/// Returns the value if it is finite, else nothing.
template <class Number>
std::optional<Number> finite(Number number) {
  return when(std::isfinite(number.value), number);
}

/// A stamp in seconds, for metrics.
constexpr Metric stamp_gauge(const char* name) { return gauge(name, 1e-9); }

// --- parts ---

template <class Visitor>
void describe(Visitor& v, const Finding& finding) {
  v.field("id", finding.id);
  v.field("level", finding.level);
  v.field("since", finding.since, "stamp, ns");
  v.field("what", finding.what);
  v.field("advice", finding.advice, "what to do");
}

template <class Visitor>
void describe(Visitor& v, const Device& device) {
  v.field("device", device.name);
  v.field("kind", Choice<kDeviceKinds>{device.kind});
  v.field("model", device.model);
  v.field("model_reason", device.model_reason,
          "why that model: configured, or the evidence for it");
  v.field("endpoint", device.endpoint, "where its data is received");
  v.field("activated", device.activated, "stamp of the first packet, ns; absent before it");
}

template <class Visitor>
void describe(Visitor& v, const ClockState& clock) {
  v.field("source", clock.source);
  v.field("trusted", clock.trusted, "True if the device's clock is trusted.",
          gauge("infuse_lidar_clock_trusted"));
  v.field("offset_ns", clock.offset.count(), "Host time minus device time.",
          gauge("infuse_lidar_clock_offset_seconds", 1e-9));
  v.field("jitter_ns", clock.jitter.count(), "Spread of the transport delay.",
          gauge("infuse_lidar_clock_jitter_seconds", 1e-9));
  v.field("skew_ppm", when(std::isfinite(clock.skew_ppm), rounded(clock.skew_ppm)),
          "Rate of the device's clock relative to the host's, minus one.",
          gauge("infuse_lidar_clock_skew_ratio", 1e-6));
  v.field("reason", when(!clock.trusted && *clock.reason != '\0', clock.reason),
          "why it is not trusted");
}

/// Datagrams lost or rejected, by cause.
struct PacketLosses {
  const LidarCounters& counters;
};

template <class Visitor>
void describe(Visitor& v, const PacketLosses& losses) {
  const auto cause = [&](const char* name, uint64_t count, const char* label, const char* text) {
    v.field(
        name, count, text,
        counter("infuse_lidar_packets_lost_total", label, "Packets lost or rejected, by cause."));
  };
  const LidarCounters& c = losses.counters;
  cause("network", c.lost_network, "cause=\"network\"", "missing by the device's counter");
  cause("kernel", c.lost_kernel, "cause=\"kernel\"", "dropped by the kernel, its buffer full");
  cause("malformed", c.malformed, "cause=\"malformed\"", "not packets of the sensor's model");
  cause("wrong_sender", c.wrong_sender, "cause=\"wrong_sender\"", "from another address");
  cause("duplicate", c.duplicates, "cause=\"duplicate\"", "repeated");
  cause("too_late", c.too_late, "cause=\"too_late\"", "too late to be used");
}

template <class Visitor>
void describe(Visitor& v, const DeviceHealth<LidarStatus>& sensor) {
  const LidarStatus& status = sensor.status;
  const LidarCounters& c = status.counters;
  v.field("device", sensor.device);
  v.field("level", status.level);
  v.field("packets_hz", non_negative(rounded(status.packets_hz)),
          "Packets per second over the last 10 s.", gauge("infuse_lidar_packets_hz"));
  v.field("sweeps_hz", non_negative(rounded(status.sweeps_hz)),
          "Sweeps per second over the last 10 s.", gauge("infuse_lidar_sweeps_hz"));
  v.field("returns_hz", non_negative(rounded(status.returns_hz)),
          "Returns per second over the last 10 s.", gauge("infuse_lidar_returns_hz"));
  v.field("packets", c.packets, "Data packets decoded since the start.",
          counter("infuse_lidar_packets_total"));
  v.field("position_packets", c.position_packets, "Position packets read since the start.",
          counter("infuse_lidar_position_packets_total"));
  v.field("sweeps", c.sweeps, "Sweeps completed since the start.",
          counter("infuse_lidar_sweeps_total"));
  v.field("dropped_sweeps", c.dropped_sweeps,
          "Sweeps not processed, because they came too late to it; live only.",
          counter("infuse_lidar_dropped_sweeps_total"));
  v.field("returns", c.returns, "Returns in the completed sweeps.",
          counter("infuse_lidar_returns_total"));
  v.field("sender", when(c.sender != 0, address_text(c.sender)),
          "IPv4 address whose packets are used; absent before the first");
  v.field("rival_sender", when(c.rival_sender != 0, address_text(c.rival_sender)),
          "another address that sends as much as a sensor now");
  v.field(
      "sender_changes", c.sender_changes,
      "Number of times that another address was taken: the one before fell silent, or sent less "
      "than a sensor.",
      counter("infuse_lidar_sender_changes_total"));
  v.field("losses", PacketLosses{c}, "datagrams lost or rejected since the start, by cause");
  v.field("outages", c.outages,
          "Gaps of a whole turn and longer without packets; what they lack is counted as lost.",
          counter("infuse_lidar_outages_total"));
  v.field("out_of_order", c.out_of_order, "Packets that arrived late and were reordered.",
          counter("infuse_lidar_packets_out_of_order_total"));
  v.field("wrong_model", c.wrong_model, "Packets that are another model's than the configured one.",
          counter("infuse_lidar_packets_wrong_model_total"));
  v.field("stray_azimuths", c.stray_azimuths,
          "Azimuths that cannot be the sensor's, replaced by interpolation.",
          counter("infuse_lidar_stray_azimuths_total"));
  v.field("clock_jumps", c.clock_jumps, "Jumps of the device's counter.",
          counter("infuse_lidar_clock_jumps_total"));
  v.field("last_packet", when(c.packets > 0, c.last_packet),
          "Stamp of the last packet; absent before the first.",
          stamp_gauge("infuse_lidar_last_packet_timestamp_seconds"));
  v.field("stamp_source",
          when(*c.source.stamp_source != '\0', Choice<kStampSources>{c.source.stamp_source}),
          "live: who stamps its packets on arrival, the network interface or the kernel");
  v.field("clock", when(c.packets > 0, c.clock));
  v.field("findings", status.findings, "raised at present");
}

template <class Visitor>
void describe(Visitor& v, const DeviceHealth<StreamStatus>& stream) {
  const StreamCounters& c = stream.status.counters;
  v.field("device", stream.device);
  v.field("kind", Choice<kStreamKinds>{stream.kind});
  v.field("level", stream.status.level);
  v.field("received_hz", non_negative(rounded(stream.status.received_hz)),
          "Received per second over the last 10 s.", gauge("infuse_stream_received_hz"));
  v.field("received", c.received, "Images, frames, samples or fixes received.",
          counter("infuse_stream_received_total"));
  v.field("used", c.used, "Of these, passed to fusion.", counter("infuse_stream_used_total"));
  v.field("refused", c.refused, "Of these, not readable.", counter("infuse_stream_refused_total"));
  v.field("lost", c.lost, "Missing by their number, dropped by the kernel, or without a sweep.",
          counter("infuse_stream_lost_total"));
  v.field("out_of_order", c.out_of_order, "Stamps earlier than the one before.",
          counter("infuse_stream_out_of_order_total"));
  v.field("last", when(c.received > 0, c.last), "Stamp of the last; absent before the first.",
          stamp_gauge("infuse_stream_last_timestamp_seconds"));
  v.field("stamp_source",
          when(*c.source.stamp_source != '\0', Choice<kStampSources>{c.source.stamp_source}),
          "of a live CAN bus: stamps of its interface, or of the kernel");
  v.field("findings", stream.status.findings, "raised at present");
}

template <class Visitor>
void describe(Visitor& v, const OdometrySourceStatus& source) {
  v.field("name", source.name);
  v.field("carries", source.carries, "it carries the odometry now");
  v.field("accepted", source.accepted, "samples used");
  v.field("rejected", source.rejected, "samples that contradict the others");
}

template <class Visitor>
void describe(Visitor& v, const TaskHealth<OdometryStatus>& odometry) {
  const OdometryStatus& status = odometry.status;
  v.field("level", odometry.level);
  v.field("usable", status.usable(), "True if odometry can be used.",
          gauge("infuse_odometry_usable"));
  v.field("speed", rounded(status.speed), "Forward speed, m/s.",
          gauge("infuse_odometry_speed_meters_per_second"));
  v.field("speed_sigma", non_negative(rounded(status.speed_sigma)), "Its standard deviation.",
          gauge("infuse_odometry_speed_sigma_meters_per_second"));
  v.field("yaw_rate", rounded(status.yaw_rate), "Yaw rate, rad/s.",
          gauge("infuse_odometry_yaw_rate_radians_per_second"));
  v.field("yaw_rate_sigma", non_negative(status.yaw_rate_sigma), "Its standard deviation.",
          gauge("infuse_odometry_yaw_rate_sigma_radians_per_second"));
  v.field("sources", status.sources, "which measurements there are, and which carry the odometry");
  v.field("standing", status.standing, "True if the vehicle stands still.",
          gauge("infuse_odometry_standing"));
  v.field("wheel_scale", status.wheel_scale, "Estimated ratio of true to measured speed.",
          gauge("infuse_odometry_wheel_scale"));
  v.field("wheel_scale_sigma", non_negative(status.wheel_scale_sigma), "Its standard deviation.",
          gauge("infuse_odometry_wheel_scale_sigma"));
  v.field("yaw_rate_bias", status.yaw_rate_bias,
          "Estimated bias of the vehicle's yaw rate sensor, rad/s.",
          gauge("infuse_odometry_yaw_rate_bias_radians_per_second"));
  v.field("yaw_rate_bias_sigma", non_negative(status.yaw_rate_bias_sigma),
          "Its standard deviation.",
          gauge("infuse_odometry_yaw_rate_bias_sigma_radians_per_second"));
  v.field("gyro_bias", status.gyro_bias, "Estimated bias of the inertial unit about z, rad/s.",
          gauge("infuse_odometry_gyro_bias_radians_per_second"));
  v.field("gyro_bias_sigma", non_negative(status.gyro_bias_sigma), "Its standard deviation.",
          gauge("infuse_odometry_gyro_bias_sigma_radians_per_second"));
  v.field("late", status.late, "Samples that arrived too late.",
          counter("infuse_odometry_late_total"));
  v.field("outliers", status.outliers, "Samples rejected as inconsistent with the motion.",
          counter("infuse_odometry_outliers_total"));
  v.field("invalid_samples", status.invalid_samples,
          "Samples without a finite quantity, or with an implausible time.",
          counter("infuse_odometry_invalid_samples_total"));
  v.field("sweeps_not_deskewed", status.not_deskewed, "Sweeps passed on as measured.",
          counter("infuse_odometry_sweeps_not_deskewed_total"));
  v.field("reason", unless_empty(status.reason), "why it is not usable");
  v.field("findings", odometry.findings, "raised at present");
}

template <class Visitor>
void describe(Visitor& v, const TaskHealth<StreetMapStatus>& streetmap) {
  const StreetMapStatus& status = streetmap.status;
  v.field("level", streetmap.level);
  v.field("state", status.state);
  v.field("p_value", fraction(rounded(status.p_value)),
          "Probability of a match with the map as good by chance.",
          gauge("infuse_streetmap_p_value"));
  v.field("entropy", fraction(rounded(status.entropy)),
          "Normalised entropy of the particle weights.", gauge("infuse_streetmap_entropy_ratio"));
  v.field("sigma", rounded(std::min(status.sigma, 1e6)),
          "Standard deviation of the position along its worst direction, m.",
          gauge("infuse_streetmap_sigma_metres"));
  v.field("elsewhere", fraction(rounded(status.elsewhere)),
          "Probability that the true place is another one that was checked.",
          gauge("infuse_streetmap_elsewhere_probability"));
  const bool fixes = status.gnss_offset.has_value();
  const Eigen::Vector2d offset = status.gnss_offset.value_or(Eigen::Vector2d::Zero());
  v.field("gnss_offset_east", when(fixes, rounded(offset.x())),
          "GNSS fixes minus the pose on the map, m to the east.",
          gauge("infuse_streetmap_gnss_offset_east_metres"));
  v.field("gnss_offset_north", when(fixes, rounded(offset.y())),
          "GNSS fixes minus the pose on the map, m to the north.",
          gauge("infuse_streetmap_gnss_offset_north_metres"));
  v.field("gnss_offset_sigma", when(fixes, rounded(status.gnss_offset_sigma)),
          "Standard deviation of this offset, m.",
          gauge("infuse_streetmap_gnss_offset_sigma_metres"));
  v.field("particles", status.particles, "Number of particles.",
          gauge("infuse_streetmap_particles"));
  v.field("hypotheses", when(status.hypotheses > 0, status.hypotheses),
          "Places of the search on all streets that explain the drive; absent without a search.",
          gauge("infuse_streetmap_hypotheses"));
  v.field("updates", status.updates, "Updates of the particle weights.",
          counter("infuse_streetmap_updates_total"));
  v.field("reason", unless_empty(status.reason), "why it is not TRACKING");
  v.field("findings", streetmap.findings, "raised at present");
}

template <class Visitor>
void describe(Visitor& v, const TaskHealth<MapStatus>& map) {
  const MapStatus& status = map.status;
  v.field("level", map.level);
  v.field("state", status.state);
  v.field("sigma", rounded(std::min(status.sigma, 1e6)),
          "Standard deviation of the position along its worst direction, m.",
          gauge("infuse_map_sigma_metres"));
  v.field("verified", status.verified, "Places of the map that confirmed the pose.",
          counter("infuse_map_verified_total"));
  v.field("found", status.found, "Times that the vehicle was found on the map.",
          counter("infuse_map_found_total"));
  v.field("dropped", status.dropped, "Sweeps that came while the background thread was behind.",
          counter("infuse_map_dropped_sweeps_total"));
  v.field("reason", unless_empty(status.reason), "why it is not TRACKING");
  v.field("findings", map.findings, "raised at present");
}

template <class Visitor>
void describe(Visitor& v, const LatencyStats& latency) {
  const auto statistic = [&](const char* name, Duration value, const char* label) {
    v.field(name, non_negative(rounded(to_seconds(value) * 1e3)), "ms",
            Metric{"infuse_stage_latency_seconds", "gauge", 1e-3, label,
                   "Latency of a stage since the start."});
  };
  statistic("p50", latency.p50, "statistic=\"p50\"");
  statistic("p99", latency.p99, "statistic=\"p99\"");
  statistic("max", latency.max, "statistic=\"max\"");
}

template <class Visitor>
void describe(Visitor& v, const StageStats& stage) {
  v.field("stage", stage.name);
  v.field("count", stage.latency.count, "Runs of a stage.", counter("infuse_stage_runs_total"));
  v.field("latency_ms", stage.latency);
  v.field("deadline_misses", stage.deadline_misses,
          "Runs that exceeded the stage's deadline, or were left out because of it.",
          counter("infuse_stage_deadline_misses_total"));
}

template <class Visitor>
void describe(Visitor& v, const QueueStats& queue) {
  v.field("queue", queue.name);
  v.field("depth", queue.depth, "Entries waiting.", gauge("infuse_queue_depth"));
  v.field("capacity", queue.capacity, "Maximum number of entries.", gauge("infuse_queue_capacity"));
  v.field("lost", queue.lost, "Entries overwritten before they were read; live only.",
          counter("infuse_queue_lost_total"));
}

template <class Visitor>
void describe(Visitor& v, const HostStats& host) {
  v.field("cpu_s", non_negative(rounded(host.cpu_s)), "Processor time of the daemon.",
          counter("process_cpu_seconds_total"));
  v.field("stages", host.stages);
  v.field("queues", host.queues);
}

template <class Visitor>
void describe(Visitor& v, const DriftEvidence& evidence) {
  v.field("axis", monitoring::name_of(evidence.axis));
  v.field("nats", non_negative(rounded(evidence.nats)));
  v.field("threshold_nats", non_negative(rounded(evidence.threshold_nats)),
          "at which drift is confirmed");
}

template <class Visitor>
void describe(Visitor& v, const CalibrationEstimate& estimate) {
  v.field("T_camera_lidar", estimate.T_camera_lidar, "by row, m");
  v.field("covariance", estimate.covariance, kCovarianceText);
  v.field("mahalanobis_distance", non_negative(rounded(estimate.mahalanobis_distance)),
          "from the calibration that was in use");
  v.field("scenes", estimate.scenes, "used by the re-estimation");
  v.field("usable", estimate.reason.empty());
  v.field("reason", unless_empty(estimate.reason), "why it is not usable");
}

template <class Visitor>
void describe(Visitor& v, const CalibrationChange& change) {
  v.field("stamp", change.stamp, "ns");
  v.field("state", change.state, "after the change");
  v.field("what", change.what);
  v.field("T_camera_lidar", change.T_camera_lidar, "in use after the change; by row, m");
}

// --- messages ---

template <class Visitor>
void describe(Visitor& v, const VersionReport& version) {
  v.message("VERSION", "Greeting, once after connecting.");
  v.field("release", version.release);
  v.field("protocol", kProtocolVersion, "major, minor; compatible within a major version");
  v.field("session", version.session, "16 hexadecimal digits; another one after a restart");
}

template <class Visitor>
void describe(Visitor& v, const DevicesReport& report) {
  v.message(name_of(report.kClass), "All sensors of the daemon.");
  v.field("stamp", report.stamp, kStampText);
  v.field("devices", report.devices);
}

template <class Visitor>
void describe(Visitor& v, const SweepReport& sweep) {
  const bool deskewed = *sweep.deskew_reason == '\0';
  v.message(name_of(sweep.kClass), "Summary of one sweep, without its points.");
  v.field("stamp", sweep.stamp, "first firing, ns since the Unix epoch; drive time in a replay");
  v.field("device", sweep.device, "the lidar");
  v.field("sequence", sweep.sequence, "number of the sweep in its device, from 0");
  v.field("span_s", non_negative(to_seconds(sweep.span)), "first firing to last");
  v.field("returns", sweep.returns);
  v.field("columns", sweep.columns, "firings");
  v.field("rings", sweep.rings, "beams");
  v.field("lost_packets", sweep.lost_packets);
  v.field("gaps", sweep.gaps, "azimuth ranges without data");
  v.field("gap_deg", non_negative(rounded(degrees(sweep.gap_angle))), "their sum");
  v.field("mean_range", finite(non_negative(rounded(sweep.mean_range))),
          "m; absent without returns");
  v.field("max_range", finite(non_negative(rounded(sweep.max_range))), "m; absent without returns");
  v.field("mean_reflectivity", finite(fraction(rounded(sweep.mean_reflectivity))),
          "absent without returns");
  v.field("has_times", sweep.has_times, "each return has its own time");
  v.field("clock_trusted", sweep.clock_trusted);
  v.field("deskewed", deskewed, "the returns are corrected for the vehicle's motion");
  v.field("deskew_reason", unless_empty(sweep.deskew_reason), "why not");
  v.field("travelled", when(deskewed, non_negative(rounded(sweep.travelled))),
          "m, distance of the vehicle from the first return to the last; absent if not deskewed");
  v.field("turned_deg", when(deskewed, non_negative(rounded(degrees(sweep.turned)))),
          "rotation of the vehicle meanwhile; absent if not deskewed");
}

template <class Visitor>
void describe(Visitor& v, const FrameReport& frame) {
  const bool matched = *frame.reason == '\0';
  v.message(name_of(frame.kClass), "An image, and the sweep during which it was exposed.");
  v.field("stamp", frame.stamp,
          "middle of the exposure, ns since the Unix epoch; drive time in a replay");
  v.field("device", frame.device, "the camera");
  v.field("sequence", frame.sequence, "number of the image in its camera");
  v.field("width", frame.width, "pixels");
  v.field("height", frame.height, "pixels");
  v.field("mean_brightness", fraction(rounded(frame.mean_brightness)));
  v.field("dark", fraction(rounded(frame.dark)), "fraction of pixels that are black");
  v.field("bright", fraction(rounded(frame.bright)), "fraction of pixels that are white");
  v.field("reason", unless_empty(frame.reason),
          "why image and sweep do not match; the fields of the sweep are then absent");
  v.field("sweep", when(matched, frame.sweep), "sequence of the sweep of the camera's lidar");
  v.field("sweep_offset_s", when(matched, to_seconds(frame.sweep_offset)),
          "exposure minus the sweep's first firing");
  v.field("points_in_view", when(matched, frame.points_in_view),
          "returns that project into the image");
  v.field("deskewed", when(matched, *frame.deskew_reason == '\0'),
          "the returns are as of the exposure");
  v.field("deskew_reason", when(matched && *frame.deskew_reason != '\0', frame.deskew_reason),
          "why not");
}

template <class Visitor>
void describe(Visitor& v, const PoseReport& pose) {
  const MapConfidence map = pose.map.value_or(MapConfidence{});
  v.message(name_of(pose.kClass), "Pose of the vehicle, at the end of each sweep.");
  v.field("stamp", pose.stamp, kStampText);
  v.field("frame", pose.frame,
          "odom: begins at the start of the drive, x ahead, and drifts; map: of the street map or "
          "the map, east-north-up at its origin");
  v.field("usable", pose.usable());
  v.field("reason", unless_empty(pose.reason), "why it is not usable");
  v.field("T_frame_vehicle", pose.T_frame_vehicle, "by row, m");
  v.field("covariance", pose.covariance, kCovarianceText);
  v.field("speed", rounded(pose.speed), "m/s along the vehicle's x");
  v.field("yaw_rate", rounded(pose.yaw_rate), "rad/s");
  v.field("state", when(pose.map.has_value(), map.state), "frame map: state of the tracker");
  v.field("doubt", when(pose.map.has_value() && *map.reason != '\0', map.reason),
          "frame map: why the state is not TRACKING");
  v.field("p_value", when(pose.map && map.p_value, fraction(rounded(map.p_value.value_or(1)))),
          "on a street map: probability of a match as good by chance");
  v.field("entropy", when(pose.map && map.entropy, fraction(rounded(map.entropy.value_or(1)))),
          "on a street map: normalised entropy of the particle weights");
}

template <class Visitor>
void describe(Visitor& v, const CalibrationReport& report) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  const bool evaluated = report.evidence.has_value();
  const Vector6 sigma =
      report.offset_sigma.unaryExpr([](double s) { return std::isfinite(s) ? s : 1e9; });
  v.message(name_of(report.kClass),
            "Calibration of a camera to its lidar, every ten seconds and on every change.");
  v.field("stamp", report.stamp, kStampText);
  v.field("device", report.camera, "the camera");
  v.field("state", report.state);
  v.field("since", report.since, "begin of the state, ns");
  v.field("policy", report.policy, "what is done with a new estimate");
  v.field("frozen", report.frozen, "no automatic changes");
  v.field("proposed", report.proposed, "a new calibration waits for the owner: infuse apply");
  v.field("can_roll_back", report.can_roll_back,
          "there is a calibration before the one in use: infuse rollback");
  v.field("T_camera_lidar", report.T_camera_lidar, "in use; by row, m");
  v.field("evaluations", report.evaluations, "images evaluated");
  v.field("scenes", report.scenes, "stored for a re-estimation");
  v.field("evidence", report.evidence,
          "for a drift, along the axis with the most; absent before the first evaluation");
  v.field("offset", when(evaluated, report.offset),
          "estimated error of the calibration: rx ry rz tx ty tz about and along the camera's "
          "axes, rad and m");
  v.field("offset_sigma", when(evaluated, sigma), "its standard deviations; 1e9 where unknown");
  v.field("delay_s", when(evaluated, rounded(report.delay)),
          "estimated delay of the camera's stamps after its exposures");
  v.field("delay_ambiguous_axis",
          evaluated && report.delay_ambiguous_axis
              ? unless_empty(monitoring::name_of(*report.delay_ambiguous_axis))
              : std::nullopt,
          "axis along which such a delay is indistinguishable from a moved camera at the recent "
          "motion: rotation about y in a steady turn, translation along z at a steady speed");
  v.field("dependence_nats", when(evaluated, report.dependence), "of the last evaluated image");
  v.field("camera_fault", when(report.fault != monitoring::CameraFault::kNone, report.fault));
  v.field("estimate", report.estimate, "the last re-estimation");
  v.field("history", report.history, "the last changes, oldest first");
}

template <class Visitor>
void describe(Visitor& v, const HealthReport& health) {
  v.message(name_of(health.kClass), "Health of the daemon, every second of drive time.");
  v.field("stamp", health.stamp, "Drive time of the figures.",
          stamp_gauge("infuse_health_timestamp_seconds"));
  v.field("drive_s", non_negative(rounded(to_seconds(health.drive))), "Since the start.",
          gauge("infuse_uptime_seconds"));
  v.field("level", health.level(), "the worst of all");
  v.field("sensors", health.sensors, "lidars");
  v.field("streams", health.streams, "cameras and vehicle sensors");
  v.field("odometry", health.odometry, "dead reckoning; absent without it");
  v.field("streetmap", health.streetmap, "tracking on the street map; absent without one");
  v.field("map", health.map, "localisation on a map of keyframes; absent without one");
  v.field("findings", health.findings, "about the daemon itself, raised at present");
  v.field("host", health.host, "figures that depend on the host; not in a replay's reports file");
}

template <class Visitor>
void describe(Visitor& v, const AlertReport& alert) {
  v.message(name_of(alert.kClass), "A problem appeared, or is over.");
  v.field("stamp", alert.stamp, kStampText);
  v.field("id", alert.id(), "the same when raised and when cleared");
  v.field("device", alert.device);
  v.field("severity", alert.finding.level);
  v.field("state", alert.raised ? AlertState::kRaised : AlertState::kCleared);
  v.field("since", alert.finding.since, "when it was raised, ns");
  v.field("what", alert.finding.what);
  v.field("advice", alert.finding.advice, "what to do");
}

template <class Visitor>
void describe(Visitor& v, const RecordReport& record) {
  v.message(name_of(record.kClass), "A recording: at its start, each second, and at its end.");
  v.field("stamp", record.stamp, kStampText);
  v.field("state",
          record.failed  ? RecordState::kFailed
          : record.ended ? RecordState::kEnded
                         : RecordState::kRecording,
          "failed: it ended early; what was written is complete");
  v.field("name", record.name, "of the drive");
  v.field("folder", record.folder, "of the drive; further parts are beside it as NAME.2, ...");
  v.field("cause", record.cause, "requested, or the id of the alert");
  v.field("since", record.since, "when it began, ns");
  v.field("duration_s", non_negative(rounded(to_seconds(record.duration))), "of the recorded data");
  v.field("bytes", record.bytes);
  v.field("drives", positive(record.drives), "number of parts");
  v.field("datagrams", record.datagrams, "of lidars");
  v.field("frames", record.frames, "of buses");
  v.field("images", record.images);
  v.field("fixes", record.fixes);
  v.field("lost", record.lost, "of all these, because processor or disk were too slow");
  v.field("reason", unless_empty(record.reason), "why it ended by itself");
}

template <class Visitor>
void describe(Visitor& v, const LostReport& lost) {
  v.message("LOST", "Reports were not sent, because the client did not read fast enough.");
  v.field("stamp", lost.stamp, "of the report sent next, ns");
  v.field("reports", positive(lost.reports), "number of reports not sent");
}

template <class Visitor>
void describe(Visitor& v, const AckReply& reply) {
  v.message("ACK", "The request was carried out.");
  v.field("op", reply.op);
}

template <class Visitor>
void describe(Visitor& v, const ErrorReply& reply) {
  v.message("ERROR", "The request, or the connection, was refused.");
  v.field("op", unless_empty(reply.op), "absent if it is not known");
  v.field("what", reply.what);
  v.field("hint", unless_empty(reply.hint), "what to do");
}

}  // namespace infuse::daemon

#pragma once

#include "daemon/protocol/calibration_descriptions.hpp"
#include "daemon/protocol/description_parts.hpp"
#include "daemon/protocol/health_descriptions.hpp"

namespace infuse::daemon {

// The one description of every message: names, order, meaning and units of its fields, and the
// metrics that export them. README.md says how a field is added. HEALTH and CALIBRATION, which have
// most of them, are in files of their own.

/// Major and minor version. A client of one major version can read all messages of that version.
inline constexpr std::array<int, 2> kProtocolVersion = {2, 0};

template <class Visitor>
void describe(Visitor& v, const VersionReport& version) {
  v.message("VERSION", "Greeting, once after connecting.");
  v.field("release", version.release);
  v.field("protocol", kProtocolVersion, "major, minor; compatible within a major version");
  v.field("session", version.session, "16 hexadecimal digits; another one after a restart");
  v.field("config_digest", unless_empty(version.config_digest),
          "checksum of the configuration in use; absent without one");
  v.field("config_version", unless_empty(version.config_version),
          "`version` of the configuration; absent without it");
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
  v.field("speed", when(pose.usable(), rounded(pose.speed)),
          "m/s along the vehicle's x; absent if not usable");
  v.field("yaw_rate", when(pose.usable(), rounded(pose.yaw_rate)), "rad/s; absent if not usable");
  v.field("state", when(pose.map.has_value(), map.state), "frame map: state of the tracker");
  v.field("doubt", when(pose.map.has_value() && *map.reason != '\0', map.reason),
          "frame map: why the state is not TRACKING");
  v.field("p_value", when(pose.map && map.p_value, fraction(rounded(map.p_value.value_or(1)))),
          "on a street map: probability of a match as good by chance");
  v.field("entropy", when(pose.map && map.entropy, fraction(rounded(map.entropy.value_or(1)))),
          "on a street map: normalised entropy of the particle weights");
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
  v.field("lost", record.lost, "of all these, because the processor or the disk was too slow");
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
  v.field("note", unless_empty(reply.note), "what follows from it");
}

template <class Visitor>
void describe(Visitor& v, const ErrorReply& reply) {
  v.message("ERROR", "The request, or the connection, was refused.");
  v.field("op", unless_empty(reply.op), "absent if it is not known");
  v.field("what", reply.what);
  v.field("hint", unless_empty(reply.hint), "what to do");
}

}  // namespace infuse::daemon

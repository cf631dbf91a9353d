#include "daemon/protocol/messages.hpp"

#include <gtest/gtest.h>

#include <limits>

#include <cmath>
#include <limits>

#include "tests/daemon/schema.hpp"

namespace infuse::daemon {
namespace {

using nlohmann::json;

const Stamp kStamp = Stamp::from_ns(1'700'000'000'123'456'789);
const std::vector<Device> kDevices = {
    {"front", "lidar", "HDL-32E", "configured", "port 2368", kStamp},
    {"rear", "lidar", "VLP-16", "the packets say so", "port 2369", std::nullopt}};

/// Encodes a report and validates its line.
template <class Report>
json encoded(const Report& report) {
  const std::string line = message(report);
  EXPECT_TRUE(is_valid_message(line));
  EXPECT_EQ(line.find('\n'), std::string::npos);
  return json::parse(line);
}

TEST(Messages, VersionNamesReleaseProtocolAndSession) {
  const json version = encoded(VersionReport{"0.1.0", "0123456789abcdef"});
  EXPECT_EQ(version["class"], "VERSION");
  EXPECT_EQ(version["release"], "0.1.0");
  EXPECT_EQ(version["protocol"], json({2, 0}));
}

TEST(Messages, FieldsThatAreNotKnownAreAbsent) {
  const json devices = encoded(DevicesReport{kStamp, kDevices});
  EXPECT_EQ(devices["stamp"], 1'700'000'000'123'456'789);
  EXPECT_EQ(devices["devices"][0]["activated"], 1'700'000'000'123'456'789);
  EXPECT_FALSE(devices["devices"][1].contains("activated"));
}

TEST(Messages, ASweepWithoutReturnsHasNoMeans) {
  SweepReport report;
  report.device = "rear";
  report.stamp = kStamp;
  report.span = from_seconds(0.0998);
  report.mean_range = report.max_range = report.mean_reflectivity = std::nan("");
  const json empty = encoded(report);
  EXPECT_EQ(empty["device"], "rear");
  EXPECT_FALSE(empty.contains("mean_range"));
  report.mean_range = 12.25;
  report.gap_angle = M_PI / 2;
  const json sweep = encoded(report);
  EXPECT_EQ(sweep["mean_range"], 12.25);
  EXPECT_EQ(sweep["gap_deg"], 90);
  EXPECT_EQ(sweep["span_s"], 0.0998);
}

TEST(Messages, AFrameWithoutASweepHasAReasonAndNoFieldsOfASweep) {
  FrameReport report;
  report.device = "front";
  report.width = 640;
  report.height = 480;
  report.points_in_view = 1234;
  const json whole = encoded(report);
  EXPECT_EQ(whole["device"], "front");
  EXPECT_EQ(whole["points_in_view"], 1234);
  EXPECT_EQ(whole["deskewed"], true);
  report.reason = "no sweep near the image";
  const json apart = encoded(report);
  EXPECT_FALSE(apart.contains("points_in_view"));
  EXPECT_EQ(apart["reason"], report.reason);
}

TEST(Messages, APoseIsAMatrixByRow) {
  PoseReport report;
  report.T_frame_vehicle.translation() << 1, 2, 3;
  report.covariance(0, 5) = 0.25;
  const json pose = encoded(report);
  EXPECT_EQ(pose["frame"], "odom");
  EXPECT_FALSE(pose.contains("state"));
  EXPECT_EQ(pose["T_frame_vehicle"].size(), 16U);
  EXPECT_EQ(pose["T_frame_vehicle"][3], 1.0);
  EXPECT_EQ(pose["T_frame_vehicle"][7], 2.0);
  EXPECT_EQ(pose["covariance"][5], 0.25);
  EXPECT_EQ(pose["usable"], true);
  report.reason = "no sample yet";
  report.frame = PoseFrame::kMap;
  report.map = {streetmap::TrackState::kUnsure, 0.25, 0.5};
  const json on_map = encoded(report);
  EXPECT_EQ(on_map["usable"], false);
  EXPECT_EQ(on_map["frame"], "map");
  EXPECT_EQ(on_map["state"], "UNSURE");
  EXPECT_EQ(on_map["p_value"], 0.25);
}

TEST(Messages, ACalibrationHasOnlyFieldsThatAreKnown) {
  CalibrationReport report;
  report.camera = "front";
  const json young = encoded(report);
  EXPECT_EQ(young["state"], "MONITORING");
  EXPECT_EQ(young["policy"], "alert-only");
  EXPECT_FALSE(young.contains("evidence"));
  EXPECT_FALSE(young.contains("estimate"));
  EXPECT_FALSE(young.contains("camera_fault"));
  report.evaluations = 1;
  report.verdict.axis = monitoring::Axis::kRotationY;
  report.verdict.evidence = 3;
  report.verdict.threshold = 17;
  report.verdict.sigma[2] = std::numeric_limits<double>::infinity();
  report.verdict.fault = monitoring::CameraFault::kDirty;
  report.estimate.emplace().reason = "two halves of the scenes disagree";
  report.history.push_back({Stamp::from_ns(5), monitoring::CalibrationState::kRecalibrated,
                            "applied", Eigen::Isometry3d::Identity()});
  const json known = encoded(report);
  EXPECT_EQ(known["evidence"]["axis"], "rotation about y");
  EXPECT_EQ(known["evidence"]["nats"], 3);
  EXPECT_EQ(known["evidence"]["threshold_nats"], 17);
  EXPECT_EQ(known["offset_sigma"][2], 1e9);
  EXPECT_EQ(known["camera_fault"], "dirty");
  EXPECT_EQ(known["estimate"]["usable"], false);
  EXPECT_EQ(known["history"][0]["what"], "applied");
}

TEST(Messages, HealthHasTheWorstLevelAndHostFiguresOnlyWhenGiven) {
  LidarStatus good;
  LidarStatus bad;
  bad.level = Level::kError;
  bad.counters.packets = 3;
  bad.counters.clock.source = ClockState::Source::kPowerUp;
  bad.counters.clock.skew_ppm = std::numeric_limits<double>::infinity();
  bad.counters.clock.reason = "settling";
  bad.findings.push_back({"loss", Level::kWarn, kStamp, "lost", "look"});
  HealthReport report;
  report.stamp = kStamp;
  report.drive = from_seconds(3);
  report.sensors = {{"front", "lidar", good}, {"rear", "lidar", bad}};
  const json plain = encoded(report);
  EXPECT_EQ(plain["level"], "ERROR");
  EXPECT_EQ(plain["drive_s"], 3);
  EXPECT_FALSE(plain.contains("host"));
  EXPECT_FALSE(plain["sensors"][0].contains("clock"));
  EXPECT_EQ(plain["sensors"][1]["clock"]["source"], "power_up");
  EXPECT_EQ(plain["sensors"][1]["clock"]["reason"], "settling");
  EXPECT_FALSE(plain["sensors"][1]["clock"].contains("skew_ppm"));

  HostStats& host = report.host.emplace();
  host.cpu_s = 1.5;
  host.stages.push_back(
      {"decode", {7, from_seconds(1e-3), from_seconds(2e-3), from_seconds(1)}, 2});
  host.queues.push_back({"sweeps", 3, 8});
  const json full = encoded(report);
  EXPECT_EQ(full["host"]["stages"][0]["latency_ms"]["p99"], 2);
  EXPECT_EQ(full["host"]["stages"][0]["deadline_misses"], 2);
  EXPECT_EQ(full["host"]["queues"][0]["capacity"], 8);
}

TEST(Messages, TheLevelOfHealthCountsCalibrations) {
  HealthReport report;
  report.sensors = {{"top", "lidar", LidarStatus{.level = Level::kWarn}}};
  EXPECT_EQ(encoded(report)["level"], "WARN");
  EXPECT_FALSE(encoded(report).contains("calibrations"));
  report.calibrations = {{"left", {}},
                         {"right", {{"drift_confirmed", Level::kError, kStamp, "drift", "look"}}}};
  const json drifted = encoded(report);
  EXPECT_EQ(drifted["level"], "ERROR");
  EXPECT_EQ(drifted["calibrations"][0]["level"], "OK");
  EXPECT_EQ(drifted["calibrations"][1]["level"], "ERROR");
  EXPECT_EQ(drifted["calibrations"][1]["findings"][0]["id"], "drift_confirmed");
}

TEST(Messages, HealthTellsPlacesOnTheStreetMapThatLookAlike) {
  HealthReport report;
  TaskHealth<StreetMapStatus>& streetmap = report.streetmap.emplace();
  streetmap.status.places.add({.pose = {1, 2, 0.5}, .probability = 0.6});
  EXPECT_FALSE(encoded(report)["streetmap"].contains("places"));
  streetmap.status.places.add({.pose = {30, 2, 0.5}, .probability = 0.4});
  const json places = encoded(report)["streetmap"]["places"];
  ASSERT_EQ(places.size(), 2U);
  EXPECT_EQ(places[1]["x"], 30);
  EXPECT_EQ(places[1]["probability"], 0.4);
  EXPECT_EQ(places[1]["covariance"].size(), 9U);
}

TEST(Messages, AnAlertHasTheSameIdWhenRaisedAndCleared) {
  AlertReport report{kStamp, "front", true, {"silent", Level::kStale, kStamp, "w", "a"}};
  const json raised = encoded(report);
  report.raised = false;
  const json cleared = encoded(report);
  EXPECT_EQ(raised["id"], "front.silent");
  EXPECT_EQ(raised["id"], cleared["id"]);
  EXPECT_EQ(raised["state"], "raised");
  EXPECT_EQ(cleared["state"], "cleared");
  EXPECT_EQ(raised["severity"], "STALE");
}

TEST(Messages, ARecordingThatEndedEarlyHasAReason) {
  RecordReport report;
  report.name = "street";
  report.folder = "/var/lib/infuse/drives/street";
  report.cause = "requested";
  report.drives = 1;
  report.duration = from_seconds(1.5);
  const json begun = encoded(report);
  EXPECT_EQ(begun["state"], "recording");
  EXPECT_EQ(begun["duration_s"], 1.5);
  EXPECT_FALSE(begun.contains("reason"));
  report.ended = true;
  EXPECT_EQ(encoded(report)["state"], "ended");
  report.failed = true;
  report.reason = "the disk is full";
  const json failed = encoded(report);
  EXPECT_EQ(failed["state"], "failed");
  EXPECT_EQ(failed["reason"], "the disk is full");
}

TEST(Messages, RepliesAreValid) {
  EXPECT_EQ(encoded(LostReport{kStamp, 17})["reports"], 17);
  EXPECT_EQ(encoded(AckReply{"poll", ""})["op"], "poll");
  EXPECT_FALSE(encoded(ErrorReply{"", "what", ""}).contains("op"));
  EXPECT_EQ(encoded(ErrorReply{"watch", "what", "hint"})["hint"], "hint");
}

TEST(Messages, InvalidUtf8IsReplaced) {
  std::vector<Device> devices = kDevices;
  devices[0].model_reason = "a \xff b";
  EXPECT_TRUE(is_valid_message(message(DevicesReport{kStamp, devices})));
}

TEST(Messages, TheSchemasRejectInvalidMessages) {
  EXPECT_FALSE(is_valid_message(R"({"class":"ACK"})"));
  EXPECT_FALSE(is_valid_message(R"({"class":"ACK","op":null})"));
  EXPECT_FALSE(is_valid_message(R"({"class":"ACK","op":"poll","more":1})"));
  EXPECT_FALSE(is_valid_message(R"({"class":"LOST","stamp":1.5,"reports":1})"));
  EXPECT_FALSE(is_valid_message(R"({"class":"LOST","stamp":1,"reports":0})"));
  EXPECT_FALSE(is_valid_message("[]"));
}

}  // namespace
}  // namespace infuse::daemon

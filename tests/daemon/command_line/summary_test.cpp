#include "daemon/command_line/summary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

/// Ten seconds of one lidar, replayed in two seconds.
Summary lidar_summary() {
  Summary summary;
  summary.path = "street.pcap";
  summary.host_s = 2;
  summary.sensors.push_back({{SensorKind::kLidar, 0},
                             {"top", "lidar", "VLP-16", "configured", "port 2368", std::nullopt}});
  LidarCounters& counters = summary.totals.counters.lidars.emplace_back();
  counters.packets = 7540;
  counters.lost_network = 20;
  counters.lost_kernel = 3;
  counters.outages = 1;
  counters.lost_in_outages = 15;
  counters.sweeps = 100;
  counters.returns = 2'000'000;
  counters.first_packet = Stamp::from_ns(0);
  counters.last_packet = Stamp::from_ns(10'000'000'000);
  summary.totals.levels.lidars.push_back(Level::kWarn);
  summary.totals.start = counters.first_packet;
  summary.totals.now = counters.last_packet;
  return summary;
}

TEST(Summary, AsJsonHasTotalsAndDevices) {
  const Json json = to_json(lidar_summary());
  EXPECT_EQ(json["drive_s"], 10);
  EXPECT_EQ(json["realtime_factor"], 5);
  EXPECT_EQ(json["packets"], 7540);
  EXPECT_EQ(json["packets_lost"], 23);
  EXPECT_EQ(json["sweeps"], 100);
  ASSERT_EQ(json["devices"].size(), 1U);
  EXPECT_EQ(json["devices"][0]["packets_hz"], 754);
  EXPECT_EQ(json["devices"][0]["level"], "WARN");
  EXPECT_TRUE(json["streams"].empty());
  EXPECT_FALSE(json.contains("odometry"));
}

TEST(Summary, HasTheFinalEvidenceOfEachCamera) {
  Summary summary = lidar_summary();
  CalibrationReport& report = summary.totals.calibrations["front"];
  report.camera = "front";
  report.state = monitoring::CalibrationState::kConfirmed;
  report.evaluations = 40;
  report.verdict.drift = monitoring::Drift::kConfirmed;
  report.verdict.evidence = 20;
  report.verdict.threshold = 19;
  summary.totals.calibration_levels["front"] = Level::kError;
  EXPECT_THAT(to_text(summary),
              HasSubstr("front: calibration CONFIRMED (ERROR), 40 evaluations; drift: rotation"));
  const Json json = to_json(summary)["calibrations"];
  ASSERT_EQ(json.size(), 1U);
  EXPECT_EQ(json[0]["level"], "ERROR");
  EXPECT_EQ(json[0]["evidence_nats"], 20);
}

TEST(Summary, AsTextHasRatesAndLosses) {
  Summary summary = lidar_summary();
  summary.stopped = true;
  summary.notes.push_back({"file ends in a packet", "street.pcap", ""});
  const std::string text = to_text(summary);
  EXPECT_THAT(text, HasSubstr("10.0 s of drive in 2.00 s (5.0 × real time), stopped early"));
  EXPECT_THAT(text,
              HasSubstr("7540 packets (754.0/s), 23 lost, 15 of them in 1 outage of a turn and "
                        "longer, 3 of these in the kernel"));
  EXPECT_THAT(text, HasSubstr("100 sweeps (10.00/s), 2000000 returns (20000 per sweep)"));
  EXPECT_THAT(text, HasSubstr("note: street.pcap: file ends in a packet"));
}

TEST(Summary, AsTextCountsInSingularAndPlural) {
  Summary summary = lidar_summary();
  summary.totals.counters.lidars[0].sweeps = 1;
  summary.totals.alerts = 1;
  StageStats total{.name = "total", .latency = {}, .deadline_misses = 2};
  total.latency.count = 19;
  summary.totals.host.stages = {total};
  const std::string text = to_text(summary);
  EXPECT_THAT(text, HasSubstr("  2 of 19 sweeps: report more than 100 ms after the last data "
                              "needed\n"));
  EXPECT_THAT(text, HasSubstr("    1 sweep (0.10/s), "));
  EXPECT_THAT(text, HasSubstr("  1 alert; "));
}

}  // namespace
}  // namespace infuse::daemon

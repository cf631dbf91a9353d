#include "daemon/pipeline/health_checks.hpp"

#include <gmock/gmock.h>

#include "daemon/pipeline/totals.hpp"

namespace infuse::daemon {
namespace {

using testing::ElementsAre;

Stamp drive_stamp(double seconds) {
  return Stamp::from_ns(1'700'000'000'000'000'000) + from_seconds(seconds);
}

SensorSetup lidar_and_camera() {
  SensorSetup setup;
  setup.lidars.push_back(
      {.device = {"top", "lidar", "HDL-32E", "configured", "port 2368", std::nullopt}});
  setup.cameras.push_back(
      {.device = {"front", "camera", "pinhole", "configured", "front", std::nullopt}});
  return setup;
}

/// A tick at which the lidar has delivered for `seconds`, and the camera nothing.
ReportItem tick_without_images(double seconds) {
  ReportItem tick;
  tick.kind = ReportItem::Kind::kTick;
  tick.stamp = drive_stamp(seconds);
  tick.counters.cameras.resize(1);
  LidarCounters& counters = tick.counters.lidars.emplace_back();
  counters.packets = counters.sweeps = static_cast<uint64_t>(seconds * 10);
  counters.first_packet = drive_stamp(0.1);
  counters.last_packet = drive_stamp(seconds);
  return tick;
}

TEST(HealthChecks, TheSilentDeviceIsNamedAndTheOthersAreActivated) {
  const SensorSetup setup = lidar_and_camera();
  HealthChecks checks(setup, HealthOptions{});
  Totals totals(setup);
  totals.start_at(drive_stamp(0));
  checks.start(drive_stamp(0));
  std::vector<AlertReport> alerts;
  HealthReport report;
  for (int second = 1; second <= 5; ++second) {
    const ReportItem tick = tick_without_images(second);
    EXPECT_EQ(checks.mark_activated(tick), second == 1);
    report = checks.check(tick, from_seconds(second), alerts);
    totals.update(tick, checks.levels());
  }
  EXPECT_EQ(checks.devices()[0].activated, drive_stamp(0.1));
  EXPECT_FALSE(checks.devices()[1].activated);
  std::vector<std::string> silent;
  for (const AlertReport& alert : alerts) {
    if (alert.raised && alert.finding.level == Level::kStale) silent.push_back(alert.device);
  }
  EXPECT_THAT(silent, ElementsAre("front"));
  EXPECT_EQ(report.streams[0].status.level, Level::kStale);
  EXPECT_THAT(totals.levels.lidars, ElementsAre(report.sensors[0].status.level));
  EXPECT_THAT(totals.levels.cameras, ElementsAre(Level::kStale));
  EXPECT_EQ(totals.counters.lidars[0].packets, 50u);
}

TEST(Totals, FewAlertsAreKeptAndAllAreCounted) {
  Totals totals;
  AlertReport alert;
  totals.count(alert);
  EXPECT_EQ(totals.alerts, 0u) << "it was cleared, not raised";
  alert.raised = true;
  for (int i = 0; i < 1000; ++i) totals.count(alert);
  EXPECT_EQ(totals.alerts, 1000u);
  EXPECT_LT(totals.first_alerts.size(), 100u);
}

}  // namespace
}  // namespace infuse::daemon

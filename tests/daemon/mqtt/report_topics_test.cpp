#include "daemon/mqtt/report_topics.hpp"

#include <gtest/gtest.h>

#include "daemon/protocol/messages.hpp"

namespace infuse::daemon {
namespace {

MqttSettings settings() {
  MqttSettings out{.host = "broker", .vehicle = "car7"};
  out.pose_interval = from_seconds(0.5);
  out.health_interval = from_seconds(10);
  return out;
}

Stamp at(double seconds) { return Stamp::from_ns(0) + from_seconds(1000 + seconds); }

TEST(ReportTopics, EveryAlertIsPublishedRetained) {
  ReportTopics topics(settings());
  const AlertReport alert{
      .stamp = at(0), .device = "lidar/1", .raised = true, .finding = {.id = "silent"}};
  for (int k = 0; k < 2; ++k) {
    const auto report = topics.select(alert);
    ASSERT_TRUE(report);
    EXPECT_EQ(report->topic, "infuse/car7/alert/lidar_1.silent");
    EXPECT_EQ(report->payload, message(alert));
    EXPECT_TRUE(report->retain);
  }
}

TEST(ReportTopics, PosesAreLimitedByFrameAndNotRetained) {
  ReportTopics topics(settings());
  int odom = 0, map = 0;
  for (int k = 0; k < 100; ++k) {  // 10 s at 10 Hz
    const PoseReport pose{.stamp = at(0.1 * k)};
    const auto report = topics.select(pose);
    if (report) {
      EXPECT_EQ(report->topic, "infuse/car7/pose/odom");
      EXPECT_FALSE(report->retain);
      ++odom;
    }
    map += topics.select(PoseReport{.stamp = at(0.1 * k), .frame = PoseFrame::kMap}) ? 1 : 0;
  }
  EXPECT_EQ(odom, 20);
  EXPECT_EQ(map, 20);
  EXPECT_TRUE(topics.select(PoseReport{.stamp = at(-500)}));  // time was set back
  MqttSettings none = settings();
  none.pose_interval = Duration{0};
  EXPECT_FALSE(ReportTopics(none).select(PoseReport{.stamp = at(0)}));
}

TEST(ReportTopics, HealthIsPublishedAtAnIntervalAndWhenItsLevelChanges) {
  ReportTopics topics(settings());
  std::vector<int> published;
  for (int second = 0; second < 30; ++second) {
    HealthReport health{.stamp = at(second)};
    if (second == 13 || second == 14)
      health.findings = {{.id = "no_sensors", .level = Level::kWarn}};
    if (topics.select(health)) published.push_back(second);
  }
  EXPECT_EQ(published, (std::vector<int>{0, 10, 13, 15, 25}));
}

TEST(ReportTopics, CalibrationsArePublishedWhenTheyChange) {
  ReportTopics topics(settings());
  CalibrationReport report{.camera = "left", .stamp = at(0)};
  EXPECT_TRUE(topics.select(report));
  report.stamp = at(1);
  ++report.evaluations;
  EXPECT_FALSE(topics.select(report));
  report.T_camera_lidar.translation().x() += 0.01;
  const auto moved = topics.select(report);
  ASSERT_TRUE(moved);
  EXPECT_EQ(moved->topic, "infuse/car7/calibration/left");
  report.state = monitoring::CalibrationState::kSuspected;
  EXPECT_TRUE(topics.select(report));
  report.camera = "right";
  EXPECT_TRUE(topics.select(report));
}

TEST(ReportTopics, MoreImportantReportsAreKeptLonger) {
  ReportTopics topics(settings());
  const int pose = topics.select(PoseReport{.stamp = at(0)})->importance;
  const int health = topics.select(HealthReport{.stamp = at(0)})->importance;
  const int calibration = topics.select(CalibrationReport{.camera = "c"})->importance;
  const int alert = topics.select(AlertReport{.device = "d"})->importance;
  EXPECT_TRUE(pose < health && health < calibration && calibration < alert);
}

TEST(TopicLevel, HasNoWildcardsAndSeparators) {
  EXPECT_EQ(topic_level("a/b+c#d\n\x7f"), "a_b_c_d__");
  EXPECT_EQ(topic_level("front left"), "front left");
}

}  // namespace
}  // namespace infuse::daemon

#include "daemon/history/history_writer.hpp"

#include <gtest/gtest.h>

#include <cerrno>

#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/faults/disk_fault.hpp"
#include "tests/stamp_at.hpp"

namespace infuse::daemon {
namespace {

class HistoryWriterTest : public testing::Test {
 protected:
  std::vector<Json> entries(const std::string& name) const {
    std::vector<Json> found;
    const auto lines = read_history(folder_ / kHistoryFile);
    for (const std::string& line : *lines) {
      const Json entry = Json::parse(line);
      if (entry["class"] == name) found.push_back(entry);
    }
    return found;
  }
  static AlertReport alert(Stamp stamp, bool raised = true) {
    return {stamp, "lidar", raised, {"silent", Level::kStale, stamp, "no data", "check"}};
  }

  TemporaryFolder folder_;
  HistoryWriter history_{folder_ / ""};
};

TEST_F(HistoryWriterTest, AnHourOfHealthIsOneLine) {
  HealthReport health;
  health.sensors.resize(1);
  health.sensors[0].device = "lidar";
  for (int second = 0; second < 3 * 3600; ++second) {
    health.stamp = at(second);
    health.sensors[0].status.level = second % 4 == 0 ? Level::kWarn : Level::kOk;
    health.sensors[0].status.counters.sweeps += 10;
    health.sensors[0].status.counters.lost_network += 1;
    history_.add(health);
  }
  history_.finish();
  const auto hours = entries("HEALTH");
  ASSERT_EQ(hours.size(), 3U);
  uint64_t sweeps = 0;
  for (const Json& hour : hours) {
    EXPECT_EQ(hour["seconds"]["OK"], 2700);
    EXPECT_EQ(hour["seconds"]["WARN"], 900);
    sweeps += hour["sensors"]["lidar"]["sweeps"].get<uint64_t>();
  }
  EXPECT_EQ(sweeps, 3U * 36'000);
}

TEST_F(HistoryWriterTest, AFlappingAlertIsWrittenOnceAnHourAndCounted) {
  HealthReport health;
  for (int second = 0; second < 7200; ++second) {
    health.stamp = at(second);
    history_.add(health);
    if (second % 10 == 5) history_.add(alert(at(second), second % 20 == 5));
  }
  history_.finish();
  EXPECT_EQ(entries("ALERT").size(), 2U);
  const auto hours = entries("HEALTH");
  ASSERT_EQ(hours.size(), 2U);
  EXPECT_EQ(hours[0]["alerts"]["lidar.silent"], 180);
}

TEST_F(HistoryWriterTest, ACalibrationIsWrittenWhenItChanges) {
  CalibrationReport report;
  report.camera = "front";
  for (int i = 0; i < 100; ++i) {
    report.stamp = at(10 * i);
    if (i == 60) report.T_camera_lidar.translation().x() = 0.05;
    history_.add(report);
  }
  const auto calibrations = entries("CALIBRATION");
  ASSERT_EQ(calibrations.size(), 2U);
  EXPECT_EQ(calibrations[1]["T_camera_lidar"][3], 0.05);
  EXPECT_EQ(calibrations[1]["stamp"], at(600).ns());
}

TEST_F(HistoryWriterTest, NothingIsLostWhileTheDiskFails) {
  {
    const DiskFault fault(folder_ / "", EIO);
    history_.add(alert(at(0)));
    EXPECT_NE(history_.problem(), "");
    EXPECT_EQ(entries("ALERT").size(), 0U);
  }
  history_.add(HealthReport{.stamp = at(1)});
  EXPECT_EQ(history_.problem(), "");
  EXPECT_EQ(entries("ALERT").size(), 1U);
}

TEST(HistoryWriter, WithoutAFolderNothingIsWritten) {
  HistoryWriter history{std::filesystem::path()};
  history.add(HealthReport{});
  history.finish();
  EXPECT_FALSE(std::filesystem::exists(kHistoryFile));
}

// A quiet year stays far below the bound of the file.
TEST_F(HistoryWriterTest, ADayTakesFewBytes) {
  HealthReport health;
  health.sensors.resize(2);
  health.sensors[0].device = "front";
  health.sensors[1].device = "rear";
  for (int hour = 0; hour <= 24; ++hour) {
    health.stamp = at(hour * 3600);
    history_.add(health);
  }
  const auto bytes = std::filesystem::file_size(folder_ / kHistoryFile);
  EXPECT_LT(bytes * 365, HistoryFile::kMaxBytes / 4);
}

}  // namespace
}  // namespace infuse::daemon

// Faults of a camera are named and start no re-estimation, a bad update is rolled back, and a stop
// does not wait for an estimate.

#include <gmock/gmock.h>

#include <boost/asio/post.hpp>
#include <chrono>
#include <filesystem>
#include <map>

#include "daemon/setup/drive_setup.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "tests/daemon/drive/calibration_drive.hpp"

namespace infuse::daemon {
namespace {

using testing::Contains;
using testing::Not;

/// Calibration history of a drive with `faults`, with policy "apply".
CalibrationHistory replay_with_faults(const std::string& faults, double seconds, int turn_stride) {
  const TemporaryFolder folder;
  make_online_drive(folder / "drive", seconds, turn_stride, faults);
  RunReplayOptions options;
  options.pipeline.calibration.supervisor.policy = monitoring::UpdatePolicy::kApply;
  const auto result = run_replay(folder / "drive", options);
  EXPECT_TRUE(result) << result.error().message();
  return result ? read_calibration_history(*result) : CalibrationHistory();
}

TEST(CalibrationFaults, LateStampsAreNamed) {
  const CalibrationHistory history = replay_with_faults(R"(
[[fault]]
kind = "late"
from_s = 15
amount = 0.2
)",
                                                        45, 1);
  EXPECT_THAT(history.faults, Contains("late"));
  EXPECT_THAT(history.alerts, Contains("front.camera_fault"));
  EXPECT_THAT(history.states, Not(Contains("RECALIBRATING")));
  EXPECT_EQ(history.last_report["state"], "UNUSABLE");
  EXPECT_EQ(history.last_report["T_camera_lidar"], history.first_report["T_camera_lidar"]);
  EXPECT_NEAR(history.last_report["delay_s"].get<double>(), 0.2, 0.05);
}

/// A second camera of the same kind, at the side.
constexpr const char* kLeft = R"(
[[camera]]
name = "left"
width = 480
height = 360
fx = 300
position = [1.2, 0.5, 1.6]
rotation_deg = [0.0, 2.0, 80.0]
rate_hz = 2
phase_s = 0.05
samples = 1
format = "jpg"
)";

/// Names of the cameras whose images others have, in the last report of each camera.
std::map<std::string, std::string> images_of(const std::filesystem::path& drive) {
  RunReplayOptions options;
  options.pipeline.calibration.monitor.detector.false_alarm_hours = 1e-3;  // after a shorter drive
  const auto result = run_replay(drive, options);
  EXPECT_TRUE(result) << result.error().message();
  std::map<std::string, std::string> found;
  for (const std::string& line : result->lines()) {
    EXPECT_TRUE(is_valid_message(line)) << line;
    const nlohmann::json report = nlohmann::json::parse(line);
    if (report["class"] == "CALIBRATION") found[report["device"]] = report.value("images_of", "");
  }
  return found;
}

// As after the cables were swapped. A camera that was turned away by far is none: the other one
// still has its own images.
TEST(CalibrationFaults, SwappedCamerasAreNamed) {
  const TemporaryFolder folder;
  const std::filesystem::path drive = folder / "drive";
  make_online_drive(drive, 15, 5, kLeft);
  using Images = std::map<std::string, std::string>;
  EXPECT_EQ(images_of(drive), (Images{{"front", ""}, {"left", ""}}));

  const std::filesystem::path front = drive / "front", left = drive / "left";
  std::filesystem::rename(front, drive / "other");
  std::filesystem::rename(left, front);
  std::filesystem::rename(drive / "other", left);
  EXPECT_EQ(images_of(drive), (Images{{"front", "left"}, {"left", "front"}}));

  std::filesystem::remove_all(left);
  std::filesystem::copy(front, left, std::filesystem::copy_options::recursive);
  EXPECT_EQ(images_of(drive), (Images{{"front", ""}, {"left", ""}}));
}

TEST(CalibrationFaults, FrozenBlackAndDirtyAreNamed) {
  const CalibrationHistory history = replay_with_faults(R"(
[[fault]]
kind = "frozen"
from_s = 10
to_s = 14
[[fault]]
kind = "black"
from_s = 17
to_s = 21
[[fault]]
kind = "dirty"
from_s = 26
amount = 1
)",
                                                        55, 5);
  EXPECT_THAT(history.faults, testing::IsSupersetOf({"frozen", "black", "dirty"}));
  EXPECT_THAT(history.states, Not(Contains("RECALIBRATING")));
  EXPECT_EQ(history.last_report["state"], "UNUSABLE");
  EXPECT_EQ(history.last_report["T_camera_lidar"], history.first_report["T_camera_lidar"]);
}

// The camera is turned until a new calibration is applied, and then turned back.
TEST(CalibrationFaults, ABadUpdateIsRolledBack) {
  const CalibrationHistory history = replay_with_faults(R"(
[[fault]]
kind = "extrinsic_step"
from_s = 8
to_s = 29
rotation_deg = [0, 1, 0]
)",
                                                        45, 5);
  EXPECT_THAT(history.states, Contains("RECALIBRATED"));
  EXPECT_THAT(history.alerts, Contains("front.calibration_changed"));
  bool result = false;
  for (const auto& entry : history.last_report["history"]) {
    result = result || entry["what"].get<std::string>().starts_with("rolled back");
  }
  EXPECT_TRUE(result) << history.last_report["history"].dump(1);
  EXPECT_EQ(history.last_report["T_camera_lidar"], history.first_report["T_camera_lidar"]);
}

TEST(CalibrationFaults, AStopDoesNotWaitForAnEstimate) {
  const TemporaryFolder folder;
  ASSERT_NO_FATAL_FAILURE(make_online_drive(folder / "drive", 30, 5, ""));
  auto setup = open_drive(folder / "drive", {}, {});
  ASSERT_TRUE(setup) << setup.error().message();
  PipelineOptions options;
  options.calibration.supervisor.min_scenes = 10;
  options.calibration.reestimate.searches = 2000;  // hours
  boost::asio::io_context io(1);
  Server server(io, {}, "0", "0123456789abcdef");
  bool ended = false;
  Replay replay(io, *std::move(setup), {std::nullopt, options}, server, nullptr, [&] {
    ended = true;
    server.finish(std::chrono::seconds(1));
  });
  std::optional<HostClock::time_point> stopped;
  bool requested = false;
  replay.publisher().add_calibration_listener([&](const CalibrationReport& report) {
    const bool recalibrating = report.state == monitoring::CalibrationState::kRecalibrating;
    if (report.evaluations >= 12 && !std::exchange(requested, true)) {
      replay.pipeline().post(
          {.kind = CalibrationCommand::Kind::kRecalibrate, .camera = report.camera});
    }
    if (!recalibrating || stopped) return;
    stopped = HostClock::now();
    replay.stop();
  });
  replay.start();
  io.run();
  EXPECT_TRUE(ended);
  ASSERT_TRUE(stopped);
  const auto took = std::chrono::duration<double>(HostClock::now() - *stopped).count();
  RecordProperty("stop_s", std::to_string(took));
  std::printf("stopped in %.3f s\n", took);
}

}  // namespace
}  // namespace infuse::daemon

// Whole drives through the daemon: lidar, camera, CAN bus, inertial unit and GNSS receiver,
// compared with the simulator's ground truth, and with damaged files.

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/recording/trajectory_file.hpp"
#include "tests/daemon/drive/simulated.hpp"
#include "tests/daemon/schema.hpp"

namespace infuse::daemon {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class DriveReplayTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto summary = simulate_car(drive_, 3);
    ASSERT_TRUE(summary) << summary.error().message();
    summary_ = *summary;
  }

  /// The reports of one class.
  static std::vector<json> reports_of(const ReplayResult& replayed, const std::string& name) {
    std::vector<json> reports;
    for (const std::string& line : replayed.lines()) {
      EXPECT_TRUE(is_valid_message(line));
      json report = json::parse(line);
      if (report["class"] == name) reports.push_back(std::move(report));
    }
    return reports;
  }

  static std::vector<std::string> raised_alerts(const ReplayResult& replayed) {
    std::vector<std::string> ids;
    for (const json& alert : reports_of(replayed, "ALERT")) {
      if (alert["state"] == "raised") ids.push_back(alert["id"]);
    }
    return ids;
  }

  ReplayResult replay(const RunReplayOptions& options = {}) const {
    auto result = run_replay(drive_, options);
    EXPECT_TRUE(result) << result.error().message();
    return *std::move(result);
  }

  /// Replaces the lines of can.log.
  template <class Change>
  void edit_can_log(Change change) const {
    std::istringstream lines(read_file(drive_ / "can.log"));
    std::string text;
    size_t number = 0;
    for (std::string line; std::getline(lines, line);) text += change(number++, line);
    write_file(drive_ / "can.log", text);
  }

  std::filesystem::path image_path(int number) const {
    return drive_ / "front" / ("00000" + std::to_string(number) + ".jpg");
  }

  TemporaryFolder folder_;
  std::filesystem::path drive_ = folder_ / "drive";
  SimulatedDrive summary_;
};

TEST_F(DriveReplayTest, EverythingIsReadAndSweepsCoveredByOdometryAreDeskewed) {
  const ReplayResult result = replay();
  ASSERT_EQ(result.sensors.size(), 5U);
  EXPECT_EQ(result.totals.counters.lidars.at(0).packets, summary_.packets);
  const StreamCounters& camera = result.totals.counters.cameras.at(0);
  EXPECT_EQ(camera.received, summary_.images);
  EXPECT_EQ(result.totals.counters.buses.at(0).received, summary_.can_frames);
  EXPECT_EQ(result.totals.counters.imu.received, 300U);  // inertial unit at 100 Hz
  EXPECT_EQ(result.totals.alerts, 0U);
  EXPECT_TRUE(result.notes.empty());
  EXPECT_TRUE(result.totals.odometry.usable());

  const auto sweeps = reports_of(result, "SWEEP");
  ASSERT_GE(sweeps.size(), 30U);
  size_t deskewed = 0;
  for (const json& sweep : sweeps) deskewed += sweep["deskewed"].get<bool>() ? 1 : 0;
  // The first sweep begins before the first CAN frame, and odometry does not cover the last one's
  // end.
  EXPECT_GE(deskewed + 2, sweeps.size());
  EXPECT_EQ(reports_of(result, "POSE").size(), sweeps.size());
  EXPECT_EQ(reports_of(result, "FRAME").size(), summary_.images);
}

TEST_F(DriveReplayTest, MotionAndPosesMatchTheTruth) {
  const ReplayResult result = replay();
  const auto truth = recording::read_trajectory(drive_ / "truth/poses.tum");
  ASSERT_TRUE(truth);
  const auto true_pose = [&](Stamp stamp) {
    const auto after = std::lower_bound(
        truth->begin(), truth->end(), stamp,
        [](const recording::TrajectoryPose& pose, Stamp at) { return pose.stamp < at; });
    return after == truth->end() ? truth->back() : *after;
  };
  size_t compared = 0;
  for (const json& sweep : reports_of(result, "SWEEP")) {
    if (!sweep["deskewed"].get<bool>()) continue;
    const Stamp begin = Stamp::from_ns(sweep["stamp"].get<int64_t>());
    const Stamp end = begin + from_seconds(sweep["span_s"].get<double>());
    const double travelled =
        (true_pose(end).T_frame_body.translation() - true_pose(begin).T_frame_body.translation())
            .norm();
    EXPECT_NEAR(sweep["travelled"].get<double>(), travelled, 0.12);  // truth to 10 ms at 10 m/s
    ++compared;
  }
  EXPECT_GT(compared, 25U);
  const auto poses = reports_of(result, "POSE");
  const auto distance = [](const json& a, const json& b) {
    return std::hypot(
        a["T_frame_vehicle"][3].get<double>() - b["T_frame_vehicle"][3].get<double>(),
        a["T_frame_vehicle"][7].get<double>() - b["T_frame_vehicle"][7].get<double>());
  };
  const json& first = poses[2];
  const json& last = poses[poses.size() - 3];
  EXPECT_TRUE(last["usable"].get<bool>());
  const double true_distance =
      (true_pose(Stamp::from_ns(last["stamp"].get<int64_t>())).T_frame_body.translation() -
       true_pose(Stamp::from_ns(first["stamp"].get<int64_t>())).T_frame_body.translation())
          .norm();
  EXPECT_GT(true_distance, 15);
  EXPECT_NEAR(distance(first, last), true_distance, 0.02 * true_distance + 0.1);
}

TEST_F(DriveReplayTest, ImagesArePairedWithTheSweepOfTheirExposure) {
  const ReplayResult result = replay();
  std::map<uint64_t, json> sweeps;
  for (json& sweep : reports_of(result, "SWEEP")) sweeps[sweep["sequence"]] = sweep;
  size_t deskewed = 0;
  for (const json& frame : reports_of(result, "FRAME")) {
    const json& sweep = sweeps.at(frame["sweep"]);
    const double after = frame["sweep_offset_s"].get<double>();
    EXPECT_LE(after, sweep["span_s"].get<double>() + 1e-6);
    if (frame["sequence"] != 0) {
      EXPECT_GE(after, -1e-3);
    }
    EXPECT_GT(frame["points_in_view"].get<int>(), 300);
    deskewed += frame["deskewed"].get<bool>() ? 1 : 0;
  }
  EXPECT_GE(deskewed + 2, summary_.images);
}

TEST_F(DriveReplayTest, SameBytesAtEveryRate) {
  const ReplayResult fast = replay();
  EXPECT_EQ(replay({.rate = 4}).reports, fast.reports);
  EXPECT_EQ(replay().reports, fast.reports);
}

TEST_F(DriveReplayTest, BadLinesAndTimesOnTheBusAreReportedAndNothingElseIsLost) {
  const ReplayResult sound = replay();
  edit_can_log([](size_t number, const std::string& line) {
    std::string text;
    if (number % 50 == 10) text += line.substr(0, line.find('#')) + "#0G\n";  // no hex digit
    if (number % 50 == 20) text += "rubbish\n";
    if (number == 30) text += "(1750000000.000001)" + line.substr(line.find(')') + 1) + "\n";
    return text + line + "\n";
  });
  const ReplayResult result = replay();
  const StreamCounters& bus = result.totals.counters.buses.at(0);
  const uint64_t refused = (summary_.can_frames + 39) / 50;  // "rubbish" has no time and is skipped
  EXPECT_EQ(bus.received, sound.totals.counters.buses.at(0).received + 1 + refused);
  EXPECT_EQ(bus.refused, refused);
  EXPECT_EQ(bus.used, sound.totals.counters.buses.at(0).used + 1);
  EXPECT_EQ(bus.out_of_order, 1U);
  EXPECT_EQ(result.totals.counters.lidars.at(0).sweeps, sound.totals.counters.lidars.at(0).sweeps);
  EXPECT_TRUE(result.totals.odometry.usable());
  EXPECT_THAT(raised_alerts(result), testing::Contains("can.out_of_order"));
  std::string notes;
  for (const Error& note : result.notes) notes += note.message() + "\n";
  EXPECT_THAT(notes, HasSubstr("can.log"));
  EXPECT_THAT(notes, HasSubstr("such lines were skipped"));
}

TEST_F(DriveReplayTest, ASilentBusLeavesSweepsNotDeskewedAndIsReported) {
  ASSERT_TRUE(simulate_car(drive_, 7));
  write_file(drive_ / "imu.csv", read_file(drive_ / "imu.csv").substr(0, 2000));
  write_file(drive_ / "gnss.csv", read_file(drive_ / "gnss.csv").substr(0, 500));
  edit_can_log([](size_t, const std::string& line) {
    return line < "(1750000000.3" ? line + "\n" : std::string();
  });
  // The lidar measures the motion without the bus.
  const ReplayResult by_lidar = replay();
  EXPECT_TRUE(by_lidar.totals.odometry.usable());
  EXPECT_THAT(raised_alerts(by_lidar), testing::Contains("can.silent"));
  EXPECT_THAT(raised_alerts(by_lidar), testing::Not(testing::Contains("odometry.untrusted")));

  const ReplayResult result = replay({.pipeline = {.odometry = {.use_lidar = false}}});
  EXPECT_FALSE(result.totals.odometry.usable());
  size_t not_deskewed = 0;
  for (const json& sweep : reports_of(result, "SWEEP")) {
    if (sweep["deskewed"].get<bool>()) continue;
    EXPECT_FALSE(sweep["deskew_reason"].get<std::string>().empty());
    ++not_deskewed;
  }
  EXPECT_GE(not_deskewed, 42U);  // what GNSS measured last carries 2.5 s more
  EXPECT_THAT(raised_alerts(result), testing::Contains("odometry.untrusted"));
  EXPECT_THAT(raised_alerts(result), testing::Contains("can.silent"));
  EXPECT_EQ(reports_of(result, "FRAME").size(), 70U);
}

TEST_F(DriveReplayTest, DamagedAndMissingImagesAreCountedAndTheOthersUsed) {
  write_file(image_path(3), read_file(image_path(3)).substr(0, 400));
  write_file(image_path(4), "no image");
  std::filesystem::remove(image_path(7));
  const ReplayResult result = replay();
  const StreamCounters& camera = result.totals.counters.cameras.at(0);
  EXPECT_EQ(camera.refused + camera.lost, 3U);
  EXPECT_EQ(camera.used, summary_.images - 3);
  EXPECT_EQ(reports_of(result, "FRAME").size(), summary_.images - 3);
}

TEST_F(DriveReplayTest, ADbcWithoutTheSignalIsRefusedByName) {
  const std::string dbc = read_file(drive_ / "vehicle.dbc");
  std::string other = dbc;
  other.replace(other.find("YAW_RATE"), 8, "YAW_RATX");
  write_file(drive_ / "vehicle.dbc", other);
  const auto refused = run_replay(drive_);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("MOTION.YAW_RATE"));
  // A malformed statement is reported; the statements around it are used.
  write_file(drive_ / "vehicle.dbc",
             dbc + "\nBO_ 77 BROKEN: x Y\n SG_ A : 0|99@1+ (1,0) [0|0] \"\" Z\n");
  const ReplayResult result = replay();
  EXPECT_FALSE(result.notes.empty());
  EXPECT_TRUE(result.totals.odometry.usable());
}

}  // namespace
}  // namespace infuse::daemon

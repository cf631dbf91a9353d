#include "daemon/tools/fleet/drive_entry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/daemon/tools/fleet/fleet_files.hpp"

namespace infuse::daemon {
namespace {

using fleet_files::calibrate_output;
using fleet_files::Folder;
using geometry::Vector6;
using testing::HasSubstr;

constexpr int64_t kFirstOfMarch = 1'772'323'200'000'000'000;  // 2026-03-01, by date(1)

/// The entry of a drive with one step.
DriveEntry entry_of(const std::string& step, int code, const std::string& output,
                    const std::string& log) {
  const Folder folder;
  folder.write_step(step, code, output, log);
  const auto made = make_drive_entry(folder.path(), {"car", "monday", ""});
  EXPECT_TRUE(made.has_value());
  auto entry = parse_drive_entry(made->dump(), "entry");
  EXPECT_TRUE(entry.has_value());
  return *entry;
}

TEST(DriveEntry, HoldsACalibrationWithWhatDrivesShareApart) {
  Vector6 moved;
  moved << 0.1, 0.2, 0.3, 1, 2, 3;
  const DriveEntry entry = entry_of("calibrate-front", 0, calibrate_output(moved).dump(), "");
  ASSERT_EQ(entry.calibrations.size(), 1U);
  const EntryCalibration& calibration = entry.calibrations[0];
  EXPECT_TRUE(calibration.usable()) << calibration.reason;
  EXPECT_EQ(calibration.camera, "front");
  EXPECT_LT((geometry::log(calibration.T_camera_lidar) - moved).norm(), 1e-9);
  EXPECT_NEAR(calibration.covariance(0, 0), 7e-4 * 7e-4, 1e-15);
  EXPECT_NEAR(calibration.covariance(3, 3), 5e-3 * 5e-3, 1e-15);
  EXPECT_NEAR(calibration.shared_covariance(0, 0), 1.7e-3 * 1.7e-3, 1e-15);
  EXPECT_NEAR(calibration.shared_covariance(1, 1), 0, 1e-15);
  EXPECT_EQ(entry.stamp->ns(), 1'772'352'003'000'000'000);  // the earlier of two scenes
}

TEST(DriveEntry, ADateInTheNameStandsForTheStamps) {
  const Folder folder;
  folder.write_step("calibrate", 0, calibrate_output(Vector6::Zero()).dump(), "");
  const auto made = make_drive_entry(folder.path(), {"car", "a", "2026-03-01"});
  EXPECT_EQ((*made)["stamp"], kFirstOfMarch);
  for (const char* wrong :
       {"2026-02-30", "2026-3-1", "yesterday", "1026-03-01", "2026-03-01T", "2026-+3-01"}) {
    EXPECT_TRUE((DriveName{"car", "a", wrong}).invalid()) << wrong;
    EXPECT_FALSE(make_drive_entry(folder.path(), {"car", "a", wrong})) << wrong;
  }
}

TEST(DriveEntry, DoesNotDependOnDurations) {
  const Folder slow, quick;
  slow.write_step("calibrate", 0, calibrate_output(Vector6::Zero(), 17.3).dump(), "12:01:07 x\n");
  quick.write_step("calibrate", 0, calibrate_output(Vector6::Zero(), 0.1).dump(), "09:30:55 x\n");
  const char* replay = R"({"drive_s":12.0,"host_s":%,"cpu_s":%,"peak_memory_mb":%,"alerts":2,
    "latency_ms":{"p50":%},"devices":[{"device":"top","level":"OK"}]})";
  const auto with = [&](const char* number) {
    std::string text(replay);
    for (size_t at; (at = text.find('%')) != text.npos;) text.replace(at, 1, number);
    return text;
  };
  slow.write_step("replay", 0, with("3.5"), "");
  quick.write_step("replay", 0, with("8.25"), "");
  const auto a = make_drive_entry(slow.path(), {"car", "a", ""});
  const auto b = make_drive_entry(quick.path(), {"car", "a", ""});
  EXPECT_EQ(a->dump(), b->dump());
  EXPECT_EQ((*a)["replay"]["levels"]["top"], "OK");
  EXPECT_EQ(parse_drive_entry(a->dump(), "")->alerts, 2);
}

TEST(DriveEntry, ADamagedDriveHasItsReason) {
  const auto what = [](int code, const std::string& output, const std::string& log) {
    const DriveEntry entry = entry_of("calibrate", code, output, log);
    EXPECT_TRUE(entry.calibrations.empty());
    return entry.failures.empty() ? "" : entry.failures[0].step + ": " + entry.failures[0].what;
  };
  EXPECT_EQ(what(3, "", "12:00 a warning\ninfuse calibrate: d/drive.toml: cannot be opened\n"),
            "calibrate: d/drive.toml: cannot be opened");
  EXPECT_EQ(what(139, "", "12:00:01 something"), "calibrate: ended by signal 11");
  EXPECT_EQ(what(124, "", ""), "calibrate: took longer than allowed");
  EXPECT_EQ(what(0, "{\"usable\":tr", ""), "calibrate: printed no result");
  EXPECT_EQ(what(2, "", "12:00:01 no message of ours"), "calibrate: ended with exit code 2");
}

TEST(DriveEntry, TheAnswerNoIsNoFailure) {
  const DriveEntry entry = entry_of(
      "calibrate", 1, R"({"camera":"front","lidar":"top","usable":false,"reason":"dark"})", "");
  EXPECT_TRUE(entry.failures.empty());
  ASSERT_EQ(entry.calibrations.size(), 1U);
  EXPECT_EQ(entry.calibrations[0].reason, "dark");
}

TEST(DriveEntry, DamagedMatricesAreAReason) {
  const auto reason = [](const char* key, const Json& value) {
    Json output = calibrate_output(Vector6::Zero());
    output[key] = value;
    return entry_of("calibrate", 0, output.dump(), "").calibrations.at(0).reason;
  };
  EXPECT_THAT(reason("T_camera_lidar", Json::array({1, 2})), HasSubstr("cannot be read"));
  EXPECT_THAT(reason("T_camera_lidar", Json(std::vector<double>(16, 1.0))),
              HasSubstr("cannot be read"));
  EXPECT_THAT(reason("covariance", "none"), HasSubstr("cannot be read"));
  EXPECT_THAT(reason("covariance_of_scenes", rows_json(geometry::Matrix6::Zero())),
              HasSubstr("covariance"));
  EXPECT_THAT(reason("covariance", rows_json(-geometry::Matrix6::Identity())),
              HasSubstr("covariance"));
  EXPECT_THAT(reason("scenes", Json::array()), HasSubstr("date"));
}

TEST(DriveEntry, OtherTextIsRefused) {
  for (const char* text : {"", "{", "[]", "null", R"({"form":2})", R"({"form":1})",
                           R"({"form":1,"vehicle":3,"drive":"a"})"}) {
    EXPECT_FALSE(parse_drive_entry(text, "entry")) << text;
  }
  const auto sparse =
      parse_drive_entry(R"({"form":1,"vehicle":"v","drive":"d","calibrations":[3,null],
                            "failures":{"a":1},"stamp":"x","replay":[]})",
                        "entry");
  ASSERT_TRUE(sparse);
  EXPECT_EQ(sparse->calibrations.size(), 2U);
  EXPECT_FALSE(sparse->calibrations[0].usable());
  EXPECT_FALSE(sparse->stamp);
  const Folder empty;
  EXPECT_FALSE(make_drive_entry(empty.path(), {"car", "a", ""}));
  EXPECT_FALSE(make_drive_entry(empty.path() / "absent", {"car", "a", ""}));
}

}  // namespace
}  // namespace infuse::daemon

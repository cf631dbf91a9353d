#include "daemon/pages/report_data.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "daemon/pages/report_page.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr int64_t kSecond = 1'000'000'000;

/// A pose by row, with its position along x.
Json pose_at(double x) { return {1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}; }

std::string pose_line(int64_t stamp, const char* frame, double x) {
  Json covariance = Json::array();
  for (int i = 0; i < 36; ++i) covariance.push_back(i);
  Json report = {{"class", "POSE"},
                 {"stamp", stamp},
                 {"frame", frame},
                 {"usable", true},
                 {"T_frame_vehicle", pose_at(x)},
                 {"covariance", covariance}};
  if (std::string_view(frame) == "map") report["state"] = "TRACKING";
  return report.dump();
}

std::string calibration_line(int64_t stamp, const char* state, double x, double nats) {
  return Json{{"class", "CALIBRATION"},
              {"stamp", stamp},
              {"device", "front"},
              {"state", state},
              {"T_camera_lidar", pose_at(x)},
              {"evidence", {{"axis", "rotation about y"}, {"nats", nats}, {"threshold_nats", 19}}}}
      .dump();
}

TEST(ThinnedTest, KeepsEvenlySpreadElementsWithinItsLimit) {
  Thinned<int> few, many;
  for (int i = 0; i < 100; ++i) few.add(i);
  EXPECT_EQ(few.kept().size(), 100U);
  for (int i = 0; i < 100'000; ++i) many.add(i);
  const auto& kept = many.kept();
  ASSERT_LE(kept.size(), Thinned<int>::kMax);
  ASSERT_GE(kept.size(), Thinned<int>::kMax / 2);
  const int step = kept[1] - kept[0];
  for (size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept[i], static_cast<int>(i) * step);
  EXPECT_GT(kept.back() + step, 99'999);
}

TEST(ReportDataTest, PosesGoToTheirFramesWithTheCovarianceOfThePosition) {
  ReportData data;
  data.add_line(pose_line(5 * kSecond, "odom", 1));
  data.add_line(pose_line(6 * kSecond, "map", 100));
  data.add_line(pose_line(7 * kSecond, "odom", 2));
  ASSERT_EQ(data.odom_poses().size(), 2U);
  ASSERT_EQ(data.map_poses().size(), 1U);
  // Order rx ry rz tx ty tz: (3,3), (3,4), (4,4) of a 6 x 6 matrix by row.
  EXPECT_EQ(data.map_poses()[0].covariance, Eigen::Vector3d(21, 22, 28));
  const Json json = data.to_json();
  EXPECT_EQ(json["duration"], 2.0);
  EXPECT_EQ(json["map"]["x"], Json::array({100.0}));
  EXPECT_EQ(json["map"]["t"], Json::array({1.0}));
  EXPECT_EQ(json["map"]["states"][0]["state"], "TRACKING");
}

TEST(ReportDataTest, TheSweepInWhichTheVehicleMovedMostIsKept) {
  ReportData data;
  EXPECT_FALSE(data.moved_sweep());
  const auto add = [&](int64_t stamp, double travelled, double turned_deg, const char* deskewed) {
    data.add_line(R"({"class":"SWEEP","stamp":)" + std::to_string(stamp) +
                  R"(,"device":"top","deskewed":)" + deskewed + R"(,"travelled":)" +
                  std::to_string(travelled) + R"(,"turned_deg":)" + std::to_string(turned_deg) +
                  "}");
  };
  add(1 * kSecond, 1, 0, "true");
  add(2 * kSecond, 0.5, -3, "true");  // 1.55 m at 20 m
  add(3 * kSecond, 1.4, 0, "true");
  add(4 * kSecond, 5, 9, "false");
  EXPECT_EQ(data.moved_sweep(), Stamp::from_ns(2 * kSecond));
  EXPECT_EQ(data.to_json()["begin_ns"], std::to_string(1 * kSecond));
}

TEST(ReportDataTest, ACalibrationHasItsFirstAndLastPoseAndTheBeginOfTheDrift) {
  ReportData data;
  data.add_line(calibration_line(1 * kSecond, "OK", 0, 0.5));
  data.add_line(calibration_line(11 * kSecond, "SUSPECTED", 0, 5));
  data.add_line(calibration_line(15 * kSecond, "CONFIRMED", 0, 20));
  data.add_line(calibration_line(60 * kSecond, "RECALIBRATED", 0.02, 0));
  const ReportedCalibration& front = data.calibrations().at("front");
  EXPECT_EQ(front.drift_since, Stamp::from_ns(11 * kSecond));
  EXPECT_EQ(front.T_first.translation().x(), 0);
  EXPECT_EQ(front.T_last.translation().x(), 0.02);
  EXPECT_EQ(front.points.size(), 4U);
  EXPECT_EQ(front.points[1]["nats"], 5.0);
  EXPECT_NEAR(data.to_json()["cameras"][0]["changed"]["translation_cm"].get<double>(), 2, 1e-9);
}

// Whatever a line is, it is counted and nothing throws.
TEST(ReportDataTest, DamagedLinesAreCounted) {
  const std::vector<std::string> damaged = {"{",
                                            "7",
                                            "[]",
                                            "null",
                                            "\xff\xfe",
                                            R"({"class":7,"stamp":1})",
                                            R"({"class":"POSE"})",
                                            R"({"class":"POSE","stamp":1.5})",
                                            std::string(size_t{5} << 20, ' ')};
  ReportData data;
  for (const std::string& line : damaged) data.add_line(line);
  EXPECT_EQ(data.unreadable(), damaged.size());
  EXPECT_EQ(data.reports(), 0U);
}

TEST(ReportDataTest, MembersOfAWrongTypeAreLeftOut) {
  ReportData data;
  for (const char* kind : {"POSE", "CALIBRATION", "HEALTH", "ALERT", "DEVICES", "OTHER"}) {
    for (const char* value : {"7", "\"x\"", "[1]", "{}", "null", "[[]]", "true"}) {
      std::string line = std::string(R"({"class":")") + kind + R"(","stamp":1)";
      for (const char* key : {"T_frame_vehicle", "covariance", "usable", "frame", "device", "state",
                              "T_camera_lidar", "evidence", "offset", "offset_sigma", "history",
                              "odometry", "level", "what", "since", "devices"}) {
        line += std::string(",\"") + key + "\":" + value;
      }
      data.add_line(line + "}");
    }
  }
  EXPECT_EQ(data.unreadable(), 0U);
  EXPECT_TRUE(data.odom_poses().empty());
  EXPECT_TRUE(data.calibrations().empty());
  EXPECT_TRUE(data.to_json().is_object());
}

TEST(ReportDataTest, ManyCamerasAndAlertsDoNotGrowTheData) {
  ReportData data;
  for (int i = 0; i < 3000; ++i) {
    Json camera = Json::parse(calibration_line(kSecond, "OK", 0, 1));
    camera["device"] = "camera" + std::to_string(i);
    data.add_line(camera.dump());
    data.add_line(R"({"class":"ALERT","stamp":1,"id":"x","state":"raised"})");
    data.add_line(calibration_line(kSecond + i, "OK", 0, 1));
  }
  const Json json = data.to_json();
  EXPECT_LE(json["cameras"].size(), 64U);
  EXPECT_LE(json["alerts"].size(), 500U);
  EXPECT_GT(json["left_out"].get<size_t>(), 4000U);
}

TEST(ReadReportsTest, AFileWithoutReportsIsAnError) {
  const std::string path = testing::TempDir() + "no_reports.jsonl";
  std::ofstream(path) << "hello\n";
  const auto data = read_reports(path);
  ASSERT_FALSE(data);
  EXPECT_THAT(data.error().message(), HasSubstr("contains no reports"));
  EXPECT_FALSE(read_reports(path + ".missing"));
}

TEST(ReadReportsTest, LongLinesAndAMissingLastLineFeedAreRead) {
  const std::string path = testing::TempDir() + "reports.jsonl";
  Json padded = Json::parse(pose_line(2 * kSecond, "odom", 1));
  padded["padding"] = std::string(200'000, 'x');
  std::ofstream(path) << pose_line(kSecond, "odom", 0) << "\n"
                      << padded.dump() << "\n\n"
                      << pose_line(3 * kSecond, "odom", 2);
  const auto data = read_reports(path);
  ASSERT_TRUE(data);
  EXPECT_EQ(data->odom_poses().size(), 3U);
  EXPECT_EQ(data->unreadable(), 0U);
}

// A name or a reason comes from files: it must not become part of the page.
TEST(ReportPageTest, NoTextOfTheDataBecomesATag) {
  const std::string page = make_report_page({{"name", "</script><img src=x onerror=alert(1)>"}});
  EXPECT_THAT(page, Not(HasSubstr("<img src=x")));
  EXPECT_THAT(page, HasSubstr("\\u003c/script>"));
}

TEST(ReportPageTest, LoadsNothing) {
  const std::string page = make_report_page(Json::object());
  EXPECT_THAT(page, HasSubstr("default-src 'none'"));
  EXPECT_THAT(page, Not(HasSubstr("https://")));
  EXPECT_THAT(page, Not(HasSubstr("innerHTML")));
  EXPECT_THAT(page, Not(HasSubstr("@PAGE")));
}

}  // namespace
}  // namespace infuse::daemon

// infuse report as a person runs it, and the comparison with the truth that it draws.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "daemon/owner/report_truth.hpp"
#include "drivers/text/text_file.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/scene/capture.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

ProgramResult report(const std::string& arguments) {
  return run_shell_command("{ " + programs_folder() + "/infuse report " + arguments + "; } 2>&1");
}

TEST(ReportCommandTest, ACaptureIsReplayedAndItsPageHasTheSweep) {
  const TemporaryFolder folder;
  fixtures::CaptureOptions options;
  options.model = &velodyne::lidar_model(velodyne::Model::kVlp16);
  options.duration = from_seconds(1.5);
  const std::string capture = (folder / "drive.pcap").string();
  ASSERT_TRUE(fixtures::make_capture(capture, options));
  const std::string page = (folder / "page.html").string();
  const ProgramResult made = report(capture + " -o " + page);
  ASSERT_EQ(made.code, 0) << made.output;
  const auto text = text::read_text(page, size_t{64} << 20);
  ASSERT_TRUE(text);
  EXPECT_THAT(*text, HasSubstr("\"url\":\"data:image/png;base64,"));
  EXPECT_THAT(*text, HasSubstr("VLP-16"));
  EXPECT_FALSE(std::filesystem::exists(page + ".reports.jsonl"));
}

TEST(ReportCommandTest, WhatCannotBeReadIsNamed) {
  const TemporaryFolder folder;
  const std::string page = (folder / "page.html").string();
  const ProgramResult no_drive = report((folder / "none").string() + " -o " + page);
  EXPECT_EQ(no_drive.code, 3);
  EXPECT_THAT(no_drive.output, HasSubstr("none"));
  std::ofstream(folder / "empty.jsonl") << "";
  const ProgramResult no_reports =
      report("none --reports " + (folder / "empty.jsonl").string() + " -o " + page);
  EXPECT_EQ(no_reports.code, 3);
  EXPECT_THAT(no_reports.output, HasSubstr("contains no reports"));
  EXPECT_FALSE(std::filesystem::exists(page));
}

/// A straight drive at 10 m/s along a line that turns by `yaw` to the axes of its frame.
Eigen::Isometry3d pose_on_line(double s, double yaw, double x) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = T.linear() * Eigen::Vector3d(10 * s, 0, 0) + Eigen::Vector3d(x, 0, 0);
  return T;
}

TEST(CompareWithTruthTest, OdometryIsMovedOntoTheFirstTruePose) {
  std::vector<recording::TrajectoryPose> truth;
  std::vector<ReportedPose> exact, short_by_a_tenth;
  for (int i = 0; i <= 100; ++i) {
    const double s = 0.1 * i;
    const Stamp stamp = Stamp::from_ns(int64_t{1} << 60) + from_seconds(s);
    truth.push_back({stamp, pose_on_line(s, 0.7, 55)});
    exact.push_back({stamp, pose_on_line(s, 0, 0)});
    short_by_a_tenth.push_back({stamp, pose_on_line(0.9 * s, 0, 0)});
  }
  const Stamp start = truth.front().stamp;
  const ComparedPath same = compare_with_truth(exact, truth, true, start);
  ASSERT_EQ(same.errors["m"].size(), 101U);
  for (const Json& error : same.errors["m"]) EXPECT_NEAR(error.get<double>(), 0, 1e-6);
  EXPECT_NEAR(same.path["x"].back().get<double>(), 55 + 100 * std::cos(0.7), 1e-6);
  const ComparedPath shorter = compare_with_truth(short_by_a_tenth, truth, true, start);
  EXPECT_NEAR(shorter.errors["m"].back().get<double>(), 10, 1e-6);
  EXPECT_NEAR(shorter.errors["t"].back().get<double>(), 10, 1e-6);
  const ComparedPath unmoved = compare_with_truth(exact, truth, false, start);
  EXPECT_NEAR(unmoved.errors["m"].front().get<double>(), 55, 1e-6);
  EXPECT_TRUE(compare_with_truth({}, truth, true, start).errors.is_null());
}

TEST(TrueMovesTest, AKnockedCameraIsFoundAndDamagedLinesAreNot) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "truth");
  std::ofstream file(folder / "truth" / "extrinsics.csv");
  file << "stamp_ns,camera,t00\n";
  const double angle = 0.7 / 57.29577951308232;
  for (int s = 0; s < 20; ++s) {
    const double a = s < 10 ? 0 : angle;
    file << s * 1'000'000'000LL << ",front," << std::cos(a) << ",0," << std::sin(a) << ",0,0,1,0,0,"
         << -std::sin(a) << ",0," << std::cos(a) << ",0,0,0,0,1\n1,front,broken\n";
  }
  file.close();
  const Json moves = true_moves_json(folder / "", Stamp::from_ns(0));
  ASSERT_EQ(moves.size(), 1U);
  EXPECT_EQ(moves[0]["t"], 10.0);
  EXPECT_EQ(moves[0]["device"], "front");
  EXPECT_NEAR(moves[0]["moved"]["rotation_deg"].get<double>(), 0.7, 0.01);
}

}  // namespace
}  // namespace infuse::daemon

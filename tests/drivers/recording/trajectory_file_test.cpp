#include "drivers/recording/trajectory_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <fstream>

#include "tests/real_data.hpp"

namespace infuse::recording {
namespace {

using testing::HasSubstr;

TEST(TrajectoryFile, ReadsTum) {
  const auto poses = parse_tum(
      "# time x y z qx qy qz qw\n1533226488.230547123 1 2 3 0 0 0.70710678 0.70710678\r\n\n"
      "1533226489 4,5,6 0 0 0 1",
      "a.tum");
  ASSERT_TRUE(poses) << poses.error().message();
  ASSERT_EQ(poses->size(), 2u);
  EXPECT_EQ((*poses)[0].stamp.ns(), 1533226488'230547123);
  EXPECT_EQ((*poses)[1].stamp.ns(), 1533226489'000000000);
  const Eigen::Vector3d turned = (*poses)[0].T_frame_body * Eigen::Vector3d(1, 0, 0);
  EXPECT_LT((turned - Eigen::Vector3d(1, 3, 3)).norm(), 1e-6) << "rotation by 90° to the left";
}

TEST(TrajectoryFile, ReadsKitti) {
  const auto poses =
      parse_kitti("1 0 0 0 0 1 0 0 0 0 1 0\n0 0 1 5e0 -1 0 0 -6 0 -1 0 7\n", "00.txt");
  ASSERT_TRUE(poses) << poses.error().message();
  ASSERT_EQ(poses->size(), 2u);
  EXPECT_EQ((*poses)[1].stamp.ns(), 1);
  const Eigen::Vector3d ahead = (*poses)[1].T_frame_body * Eigen::Vector3d(0, 0, 1);
  EXPECT_LT((ahead - Eigen::Vector3d(6, -6, 7)).norm(), 1e-12);
}

TEST(TrajectoryFile, ReportsTheInvalidLine) {
  const auto tum = [](const char* text) { return parse_tum(text, "t").error().message(); };
  const auto kitti = [](const char* text) { return parse_kitti(text, "k").error().message(); };
  EXPECT_THAT(tum("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 1\n"), HasSubstr("t:2: 7 numbers"));
  EXPECT_THAT(tum("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1"), HasSubstr("t:2: stamps must increase"));
  EXPECT_THAT(tum("1 0 0 0 0 0 0 0.5"), HasSubstr("t:1: the norm of the quaternion"));
  EXPECT_THAT(tum("1 0 0 zero 0 0 0 1"), HasSubstr("t:1: not a number"));
  EXPECT_THAT(tum("1 0 0 nan 0 0 0 1"), HasSubstr("t:1: not a number"));
  EXPECT_THAT(tum("99999999999 0 0 0 0 0 0 1"), HasSubstr("not a time"));
  EXPECT_THAT(tum("# nothing\n"), HasSubstr("no pose"));
  EXPECT_THAT(kitti("1 0 0 0 0 1 0 0 0 0 1"), HasSubstr("k:1: 11 numbers"));
  EXPECT_THAT(kitti("1 0 0 0 0 2 0 0 0 0 1 0"), HasSubstr("k:1: not a rigid motion"));
  EXPECT_THAT(kitti("1 0 0 0 0 1 0 0 0 0 -1 0"), HasSubstr("k:1: not a rigid motion"));
  EXPECT_THAT(read_trajectory("/nonexistent/x.tum").error().message(),
              HasSubstr("/nonexistent/x.tum"));
}

TEST(TrajectoryFile, FormatAndParseRoundTrip) {
  std::vector<TrajectoryPose> poses(3);
  for (int i = 0; i < 3; ++i) {
    TrajectoryPose& pose = poses[static_cast<size_t>(i)];
    pose.stamp = Stamp::from_ns(-1'500'000'001 + i * 1'000'000'000LL);
    pose.T_frame_body.linear() =
        Eigen::AngleAxisd(1.0 + i, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
    pose.T_frame_body.translation() << 1e5 + i, -0.125, 1e-3;
  }
  const auto expect_same = [&](const Result<std::vector<TrajectoryPose>>& again, bool stamps) {
    ASSERT_TRUE(again) << again.error().message();
    ASSERT_EQ(again->size(), poses.size());
    for (size_t i = 0; i < poses.size(); ++i) {
      if (stamps) {
        EXPECT_EQ((*again)[i].stamp, poses[i].stamp);
      }
      EXPECT_LT(((*again)[i].T_frame_body.matrix() - poses[i].T_frame_body.matrix()).norm(), 1e-4);
    }
  };
  expect_same(parse_tum(format_tum(poses), "t"), true);
  expect_same(parse_kitti(format_kitti(poses), "k"), false);
  const auto file = std::filesystem::temp_directory_path() /
                    ("infuse_trajectory_" + std::to_string(::getpid()) + ".txt");
  std::ofstream(file) << format_kitti(poses);
  expect_same(read_trajectory(file), false);
  std::ofstream(file) << "# a comment\n" << format_tum(poses);
  expect_same(read_trajectory(file), true);
  std::filesystem::remove(file);
}

TEST(TrajectoryFile, ReadsTheRealPosesOfKitti00) {
  INFUSE_REAL_DATA_OR_SKIP(path, "registration/kitti_odometry_00");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(path)) {
    if (entry.path().extension() != ".txt") continue;
    const auto poses = read_trajectory(entry.path());
    if (!poses || poses->size() != 4541) continue;
    double length = 0;
    for (size_t i = 1; i < poses->size(); ++i) {
      length +=
          ((*poses)[i].T_frame_body.translation() - (*poses)[i - 1].T_frame_body.translation())
              .norm();
    }
    EXPECT_NEAR(length, 3724, 1);  // as published by the benchmark
    return;
  }
  ADD_FAILURE() << "no file of 4541 poses";
}

}  // namespace
}  // namespace infuse::recording

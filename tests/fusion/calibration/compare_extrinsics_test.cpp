#include "fusion/calibration/compare_extrinsics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

using testing::ElementsAre;

const std::vector<RigCamera>& small_rig() {
  static const std::vector<RigCamera> rig{
      RigCamera{geometry::CameraModel(painted::small_camera())}};
  return rig;
}

Eigen::Isometry3d turned(double degrees, Eigen::Index axis = 1) {
  return geometry::exp(degrees * kDegree * geometry::Vector6::Unit(axis)) *
         painted::twelve_scene_drive().T_camera_lidar;
}

TEST(SignPermutation, MatchesTheClosedForms) {
  EXPECT_EQ(sign_permutation_p_value(std::vector<double>{}, 1), 1);
  EXPECT_EQ(sign_permutation_p_value(std::vector<double>(5, 0.3), 1), 2.0 / 32);
  EXPECT_EQ(sign_permutation_p_value(std::vector<double>{1, -1, 2, -2}, 1), 1);
  // Only 1 - 2 - 3 + 4 and its opposite have a smaller sum than 1 + 2 + 3 - 4.
  EXPECT_EQ(sign_permutation_p_value(std::vector<double>{1, 2, 3, -4}, 1), 14.0 / 16);
  // Of 20 000 drawn patterns of 20 signs none is expected to be all equal.
  EXPECT_LT(sign_permutation_p_value(std::vector<double>(20, 1.0), 1), 2e-4);
}

TEST(SignPermutation, OfRandomSignsIsEvenlyDistributed) {
  std::mt19937_64 random(3);
  int small = 0;
  for (int trial = 0; trial < 400; ++trial) {
    std::vector<double> values;
    for (int k = 0; k < 10; ++k) {
      values.push_back(static_cast<double>(random() >> 11) * 0x1p-52 - 1);
    }
    small += sign_permutation_p_value(values, 1) < 0.2 ? 1 : 0;
  }
  EXPECT_NEAR(small, 80, 25);  // three standard deviations
}

TEST(GroupSimilar, JoinsChains) {
  Eigen::MatrixXd similarity = Eigen::MatrixXd::Identity(5, 5);
  similarity(0, 3) = similarity(3, 0) = similarity(3, 4) = similarity(4, 3) = 0.8;
  similarity(1, 2) = similarity(2, 1) = 0.3;
  EXPECT_THAT(group_similar(similarity), ElementsAre(0, 1, 2, 0, 0));
}

TEST(CompareExtrinsics, NamesTheBetterAndSaysNothingOfEqualOnes) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  const auto compared =
      compare_extrinsics(drive.scenes, small_rig(), turned(1), drive.T_camera_lidar, {});
  ASSERT_TRUE(compared.usable()) << compared.reason;
  EXPECT_EQ(compared.scenes.size(), 12U);
  EXPECT_EQ(compared.independent, 12U);
  EXPECT_LT(compared.p_value, 0.01);
  EXPECT_GT(compared.better, 0);
  EXPECT_GT(compared.mean_b.edge_gradient, compared.mean_a.edge_gradient);
  EXPECT_GT(compared.mean_b.dependence, compared.mean_a.dependence);
  const auto reversed =
      compare_extrinsics(drive.scenes, small_rig(), drive.T_camera_lidar, turned(1), {});
  EXPECT_EQ(reversed.p_value, compared.p_value);
  EXPECT_NEAR(reversed.better, -compared.better, 1e-9);

  // Nothing is said of equal poses and of one place.
  const auto equal =
      compare_extrinsics(drive.scenes, small_rig(), drive.T_camera_lidar, drive.T_camera_lidar, {});
  EXPECT_EQ(equal.p_value, 1);
  const std::vector<Scene> one_place(8, drive.scenes.front());
  const auto repeated =
      compare_extrinsics(one_place, small_rig(), turned(1), drive.T_camera_lidar, {});
  EXPECT_FALSE(repeated.usable());
  EXPECT_EQ(repeated.independent, 1U);
  EXPECT_EQ(repeated.p_value, 1);
}

TEST(CompareExtrinsics, LeavesOpenWhatHalfAPixelCouldFeign) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  // 0.1 degrees are 0.6 pixels: with the principal point 0.3 pixels off both fit alike.
  const auto without_bias =
      compare_extrinsics(drive.scenes, small_rig(), turned(0.1), drive.T_camera_lidar, {.bias = 0});
  EXPECT_LT(without_bias.p_value, 0.05);
  EXPECT_GT(without_bias.better, 0);
  const auto near =
      compare_extrinsics(drive.scenes, small_rig(), turned(0.1), drive.T_camera_lidar, {});
  EXPECT_EQ(near.p_value, 1);
  EXPECT_EQ(near.bias_share, 1);

  // No principal point feigns a rotation about the optical axis.
  const auto rolled =
      compare_extrinsics(drive.scenes, small_rig(), turned(1, 2), drive.T_camera_lidar, {});
  EXPECT_LT(rolled.p_value, 0.05);
  EXPECT_GT(rolled.better, 0);
  EXPECT_LT(rolled.bias_share, 0.5);
}

}  // namespace
}  // namespace infuse::calibration

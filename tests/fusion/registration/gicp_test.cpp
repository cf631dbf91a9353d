#include "fusion/registration/gicp.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "fusion/registration/align_points.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/fusion/registration/random_room.hpp"

namespace infuse::registration {
namespace {

Eigen::Isometry3d small_motion(double scale) {
  geometry::Vector6 twist;
  twist << 0.01, -0.02, 0.05, 0.3, -0.2, 0.1;
  return geometry::exp(scale * twist);
}

TEST(Gicp, FindsTheMotionBetweenTwoSweepsOfARoom) {
  const Eigen::Isometry3d truth = small_motion(1);
  const auto target =
      prepare_cloud(random_room(1, 20'000, 0.01, Eigen::Isometry3d::Identity()).points());
  const auto source = prepare_cloud(random_room(2, 20'000, 0.01, truth).points());
  const RegistrationResult result = gicp(target, source.cloud, Eigen::Isometry3d::Identity());
  ASSERT_TRUE(result.usable()) << result.reason;
  EXPECT_EQ(result.free_directions, 0) << result.free_directions_text();
  const geometry::Vector6 error = geometry::log(truth * result.T_target_source.inverse());
  EXPECT_LT(error.head<3>().norm(), 1e-3);
  EXPECT_LT(error.tail<3>().norm(), 0.01);
  EXPECT_LT((result.information * result.covariance - geometry::Matrix6::Identity()).norm(), 1e-5);
}

TEST(Gicp, PointsAreAlignedAsPreparedCloudsAre) {
  const PointCloud target = random_room(1, 5000, 0.01, Eigen::Isometry3d::Identity());
  const PointCloud source = random_room(2, 5000, 0.01, small_motion(1));
  const auto rows = [](const PointCloud& cloud) {
    std::vector<Eigen::Vector3f> points;
    for (size_t k = 0; k < cloud.size(); ++k) {
      points.emplace_back(cloud.x[k], cloud.y[k], cloud.z[k]);
    }
    return points;
  };
  const RegistrationResult expected =
      gicp(prepare_cloud(target.points()), prepare_cloud(source.points()).cloud, small_motion(0.9));
  const RegistrationResult result = align_points(rows(target), rows(source), small_motion(0.9));
  ASSERT_TRUE(result.usable()) << result.reason;
  EXPECT_EQ(result.T_target_source.matrix(), expected.T_target_source.matrix());
  EXPECT_EQ(result.covariance, expected.covariance);
  EXPECT_FALSE(align_points({}, rows(source)).usable());
  EXPECT_FALSE(align_points(rows(target), {}).usable());
}

TEST(Gicp, StatesTheAccuracyThatItHas) {
  constexpr int kPairs = 40;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  double sum = 0;
  for (unsigned i = 0; i < kPairs; ++i) {
    geometry::Vector6 twist;
    for (int k = 0; k < 6; ++k) twist[k] = (k < 3 ? 0.02 : 0.2) * normal(random);
    const Eigen::Isometry3d truth = geometry::exp(twist);
    const auto target =
        prepare_cloud(random_room(2 * i + 1, 4000, 0.03, Eigen::Isometry3d::Identity()).points());
    const auto source = prepare_cloud(random_room(2 * i + 2, 4000, 0.03, truth).points());
    const RegistrationResult result = gicp(target, source.cloud, Eigen::Isometry3d::Identity());
    ASSERT_TRUE(result.usable()) << result.reason;
    const geometry::Vector6 error = geometry::log(truth * result.T_target_source.inverse());
    sum += error.dot(result.information * error) / 6;
  }
  EXPECT_GT(sum / kPairs, 0.5);
  EXPECT_LT(sum / kPairs, 2);
}

TEST(Gicp, NamesTheDirectionsThatAFloorLeavesFree) {
  PointCloud floor = random_room(1, 8000, 0.0, Eigen::Isometry3d::Identity());
  for (float& z : floor.z) z = -1.5F;
  PointCloud moved = floor;
  for (float& z : moved.z) z = -1.4F;
  for (float& x : moved.x) x += 0.013F;
  const auto target = prepare_cloud(floor.points());
  const auto source = prepare_cloud(moved.points());
  const RegistrationResult result = gicp(target, source.cloud, Eigen::Isometry3d::Identity());
  EXPECT_EQ(result.free_directions, 3);
  const std::string text = result.free_directions_text();
  for (const char* name : {"rotation about z", "translation along x", "translation along y"}) {
    EXPECT_NE(text.find(name), std::string::npos) << text;
  }
  EXPECT_NEAR(result.T_target_source.translation().z(), -0.1, 1e-4);
  EXPECT_NEAR(result.information.diagonal()[3], 0, 1e-6 * result.information.diagonal()[5]);
}

/// Points on a straight road of 100 m, 6 m wide, between low walls, with boxes beside it; seeded.
PointCloud narrow_road(unsigned seed, const Eigen::Isometry3d& T_road_sensor) {
  constexpr size_t kPoints = 16'000;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> noise(0, 0.01);
  PointCloud cloud;
  cloud.resize(kPoints);
  for (size_t i = 0; i < kPoints; ++i) {
    const double side = unit(random) > 0 ? 3 : -3;
    Eigen::Vector3d p(50 * unit(random), 3 * unit(random), noise(random) - 1.7);
    if (i % 4 == 1) p = {p.x(), side + noise(random), 0.5 * unit(random) - 1.2};
    if (i % 8 == 2) {
      p = {10 * std::round(5 * unit(random)) + noise(random),
           side * (1 - 0.15 * (unit(random) + 1)), 0.5 * unit(random) - 1.2};
    }
    const Eigen::Vector3d seen = T_road_sensor.inverse() * p;
    cloud.x[i] = static_cast<float>(seen.x());
    cloud.y[i] = static_cast<float>(seen.y());
    cloud.z[i] = static_cast<float>(seen.z());
  }
  return cloud;
}

// The road reaches far along x and little across, but its ground determines the roll.
TEST(Gicp, TheGroundOfANarrowRoadDeterminesItsRoll) {
  geometry::Vector6 twist;
  twist << 0.01, 0.002, 0.005, 0.2, 0.05, 0.03;
  const Eigen::Isometry3d truth = geometry::exp(twist);
  const auto target = prepare_cloud(narrow_road(1, Eigen::Isometry3d::Identity()).points());
  const auto source = prepare_cloud(narrow_road(2, truth).points());
  const RegistrationResult result = gicp(target, source.cloud, Eigen::Isometry3d::Identity());
  ASSERT_TRUE(result.usable()) << result.reason;
  EXPECT_EQ(result.free_directions, 0) << result.free_directions_text();
  const geometry::Vector6 error = geometry::log(truth * result.T_target_source.inverse());
  EXPECT_LT(error.head<3>().norm(), 1e-3);
  EXPECT_LT(error.tail<3>().norm(), 0.02);
  EXPECT_LT(error.dot(result.information * error) / 6, 4);
}

TEST(Gicp, GivesAReasonForBadInput) {
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  const auto room = prepare_cloud(random_room(1, 5000, 0.01, identity).points());
  const PreparedCloud empty = prepare_cloud(PointCloud().points());
  PointCloud nan = random_room(1, 1000, 0.01, identity);
  std::fill(nan.x.begin(), nan.x.end(), std::numeric_limits<float>::quiet_NaN());
  const PreparedCloud not_finite = prepare_cloud(nan.points());
  const PreparedCloud ten = prepare_cloud(random_room(1, 10, 0.01, identity).points());
  PointCloud far = random_room(1, 5000, 0.01, identity);
  for (float& x : far.x) x += 500;
  const PreparedCloud disjoint = prepare_cloud(far.points());
  const auto reason = [&](const PreparedCloud& target, const PreparedCloud& source) {
    const RegistrationResult result = gicp(target, source.cloud, identity);
    EXPECT_FALSE(result.usable());
    EXPECT_TRUE(result.information.isZero() || result.converged);
    return std::string(result.reason);
  };
  EXPECT_EQ(reason(empty, room), "the target has no finite points");
  EXPECT_EQ(reason(room, empty), "the source has no finite points");
  EXPECT_EQ(reason(not_finite, room), "the target has no finite points");
  EXPECT_EQ(reason(room, ten), "the source has too few points");
  EXPECT_EQ(reason(ten, room), "the target has too few points");
  EXPECT_EQ(reason(room, disjoint), "the clouds do not overlap");
  EXPECT_EQ(reason(room, room), "the clouds are identical: they do not show the accuracy");
}

TEST(Gicp, DoesNotAllocateAfterWarmUp) {
  const PointCloud one = random_room(1, 5000, 0.01, Eigen::Isometry3d::Identity());
  const PointCloud two = random_room(2, 5000, 0.01, small_motion(0.5));
  CloudPreparer preparer;
  PreparedCloud target, source;
  Gicp gicp;
  size_t before = 0;
  for (int i = 0; i < 3; ++i) {
    before = allocation_count();
    preparer.prepare(one.points(), {}, target);
    preparer.prepare(two.points(), {}, source);
    EXPECT_TRUE(gicp.align(target, source.cloud, Eigen::Isometry3d::Identity()).usable());
  }
  EXPECT_EQ(allocation_count(), before);
}

}  // namespace
}  // namespace infuse::registration

#include "fusion/motion/trajectory_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/fusion/motion/true_drive.hpp"

namespace infuse::motion {
namespace {

using geometry::StampedPose;
using geometry::Vector6;

Eigen::Isometry3d planar_pose(double x, double y, double yaw) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << x, y, 0;
  T.linear() = geometry::rotation_exp({0, 0, yaw});
  return T;
}

/// A straight road of n metres, one pose per metre, 10 m/s.
std::vector<PosePair> straight_road(int metres) {
  std::vector<PosePair> pairs;
  for (int i = 0; i <= metres; ++i)
    pairs.push_back({seconds(0.1 * i), planar_pose(i, 0, 0), planar_pose(i, 0, 0)});
  return pairs;
}

Eigen::Isometry3d frame_motion() {
  Vector6 twist;
  twist << 0.3, -0.2, 2.1, 10, -40, 5;
  return geometry::exp(twist);
}

/// A winding climb: the positions span all axes.
std::vector<PosePair> winding_road() {
  std::vector<PosePair> pairs;
  for (int i = 0; i < 300; ++i) {
    Eigen::Isometry3d T = planar_pose(0.5 * i, 20 * std::sin(0.03 * i), 0.02 * i);
    T.translation().z() = 5 * std::cos(0.05 * i);
    pairs.push_back({seconds(0.1 * i), T, T});
  }
  return pairs;
}

TEST(TrajectoryError, AlignmentFindsTheMotionBetweenTheFrames) {
  std::vector<PosePair> pairs = winding_road();
  for (PosePair& pair : pairs) pair.estimate = frame_motion().inverse() * pair.truth;
  const AbsoluteError aligned = absolute_error(pairs);
  ASSERT_TRUE(aligned.usable());
  EXPECT_LT(aligned.translation.max, 1e-9);
  EXPECT_LT(aligned.rotation.max, 1e-9);
  EXPECT_LT((aligned.T_truth_estimate.matrix() - frame_motion().matrix()).norm(), 1e-9);
  EXPECT_LT(absolute_error(pairs, Alignment::kFirstPose).translation.max, 1e-9);
  EXPECT_GT(absolute_error(pairs, Alignment::kNone).translation.rms, 10);
  for (PosePair& pair : pairs) pair.estimate.translation() *= 0.5;
  const AbsoluteError similar = absolute_error(pairs, Alignment::kSimilarity);
  EXPECT_NEAR(similar.scale, 2, 1e-9);
  EXPECT_LT(similar.translation.max, 1e-9);
  EXPECT_GT(absolute_error(pairs, Alignment::kRigid).translation.rms, 1);
}

TEST(TrajectoryError, OnAStraightRoadTheOrientationsDetermineTheRotationAboutIt) {
  std::vector<PosePair> pairs = straight_road(40);
  for (size_t i = 0; i < pairs.size(); ++i) {
    const double wiggle = 0.02 * std::sin(static_cast<double>(i));
    pairs[i].truth.translation().z() += wiggle;  // suspension
    pairs[i].estimate.translation().y() += wiggle;
    pairs[i].estimate = frame_motion().inverse() * pairs[i].estimate;
  }
  const AbsoluteError aligned = absolute_error(pairs);
  ASSERT_TRUE(aligned.usable());
  EXPECT_LT(aligned.translation.max, 0.05);
  EXPECT_LT(aligned.rotation.max, 0.01);
}

TEST(TrajectoryError, AlignmentIsNeverAReflection) {
  std::vector<PosePair> pairs = straight_road(50);  // a line: reflections fit as well
  for (PosePair& pair : pairs) pair.estimate = planar_pose(0, 3, 1) * pair.truth;
  const AbsoluteError aligned = absolute_error(pairs);
  EXPECT_NEAR(aligned.T_truth_estimate.linear().determinant(), 1, 1e-9);
  EXPECT_LT(aligned.translation.max, 1e-9);
}

// Small changes of the alignment only increase the error.
TEST(TrajectoryError, AlignmentIsTheLeastSquaresSolution) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  std::vector<PosePair> pairs = winding_road();
  for (PosePair& pair : pairs) {
    for (int i = 0; i < 3; ++i) pair.estimate.translation()[i] += normal(random);
  }
  const AbsoluteError best = absolute_error(pairs);
  for (int i = 0; i < 6; ++i) {
    for (const double step : {-1e-2, 1e-2}) {
      std::vector<PosePair> changed = pairs;
      for (PosePair& pair : changed) {
        pair.estimate =
            geometry::exp(step * Vector6::Unit(i)) * best.T_truth_estimate * pair.estimate;
      }
      EXPECT_GT(absolute_error(changed, Alignment::kNone).translation.rms, best.translation.rms);
    }
  }
}

TEST(TrajectoryError, StatisticsOfKnownErrors) {
  std::vector<PosePair> pairs = straight_road(3);
  const double errors[] = {3, 0, 4, 1};
  for (size_t i = 0; i < 4; ++i) pairs[i].estimate.translation().y() = errors[i];
  const ErrorStatistics s = absolute_error(pairs, Alignment::kNone).translation;
  EXPECT_EQ(s.count, 4u);
  EXPECT_DOUBLE_EQ(s.mean, 2);
  EXPECT_DOUBLE_EQ(s.median, 2);
  EXPECT_DOUBLE_EQ(s.max, 4);
  EXPECT_DOUBLE_EQ(s.rms, std::sqrt(26.0 / 4));
}

TEST(TrajectoryError, RelativeErrorOfAWrongScaleAndATurn) {
  std::vector<PosePair> pairs = straight_road(100);
  for (size_t i = 0; i < pairs.size(); ++i) {
    const double x = static_cast<double>(i);
    pairs[i].estimate = planar_pose(1.02 * x, 0, 0);
  }
  const RelativeError scale = relative_error(pairs, Duration(1'000'000'000));  // 10 m
  ASSERT_TRUE(scale.usable());
  EXPECT_EQ(scale.translation.count, 91u);
  EXPECT_NEAR(scale.translation.rms, 0.2, 1e-9);
  EXPECT_NEAR(scale.rotation.max, 0, 1e-9);
  for (size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].estimate = planar_pose(static_cast<double>(i), 0, 0.001 * static_cast<double>(i));
  }
  EXPECT_NEAR(relative_error(pairs, Duration(1'000'000'000)).rotation.mean, 0.01, 1e-9);
  EXPECT_FALSE(relative_error(pairs, Duration(60'000'000'000)).usable());
}

TEST(TrajectoryError, KittiErrorOfAWrongScale) {
  std::vector<PosePair> pairs = straight_road(1000);
  for (PosePair& pair : pairs) pair.estimate.translation() *= 1.01;
  const KittiError error = kitti_error(pairs);
  ASSERT_TRUE(error.usable());
  ASSERT_EQ(error.segments.size(), 8u);
  // A segment ends at the first pose beyond its length: 101 m for 100.
  EXPECT_NEAR(error.segments[0].translation, 0.0101, 1e-9);
  EXPECT_EQ(error.segments[0].count, 90u) << "from poses 0, 10, … 890";
  EXPECT_EQ(error.segments[7].count, 20u);
  EXPECT_NEAR(error.translation, 0.01, 1e-4);
  EXPECT_NEAR(error.rotation, 0, 1e-12);
}

TEST(TrajectoryError, KittiErrorOfASteadyTurn) {
  std::vector<PosePair> pairs = straight_road(400);
  for (size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].estimate = planar_pose(static_cast<double>(i), 0, 1e-4 * static_cast<double>(i));
  }
  const KittiError error = kitti_error(pairs);
  EXPECT_NEAR(error.segments[1].rotation, 1e-4 * 201 / 200, 1e-9);
  EXPECT_EQ(error.segments[4].count, 0u);
  EXPECT_FALSE(kitti_error(straight_road(90)).usable());
}

TEST(TrajectoryError, PairsByTimeAndLeavesOutPosesWithoutTruth) {
  const TrueDrive drive(10, [](double) {
    Vector6 twist;
    twist << 0, 0, 0.3, 10, 0, 0;
    return twist;
  });
  std::vector<StampedPose> truth, estimate;
  for (int i = 0; i < 100; ++i) {
    if (i > 40 && i < 60) continue;  // a gap of 2 s
    truth.push_back({seconds(0.1 * i), drive.pose(0.1 * i), geometry::Matrix6::Zero()});
  }
  for (int i = -3; i < 40; ++i) {
    const double t = 0.25 * i + 0.033;
    estimate.push_back({seconds(t), t < 0 ? Eigen::Isometry3d::Identity() : drive.pose(t),
                        geometry::Matrix6::Zero()});
  }
  const std::vector<PosePair> pairs = pair_by_time(estimate, truth);
  ASSERT_EQ(pairs.size(), 32u) << "40 from the start to 9.9 s, less 8 in the gap";
  for (const PosePair& pair : pairs) {
    EXPECT_LT((pair.truth.matrix() - pair.estimate.matrix()).norm(), 1e-9);
  }
  EXPECT_FALSE(absolute_error(std::span(pairs).first(2)).usable());
}

}  // namespace
}  // namespace infuse::motion

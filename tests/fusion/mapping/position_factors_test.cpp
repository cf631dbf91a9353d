#include "fusion/mapping/position_factors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::mapping {
namespace {

/// Truth: a bend of 300 m in a map whose axes odometry does not know; the odometry drifts.
struct Drive {
  std::vector<Pose<3>> truth;
  PoseGraph<3> graph;
  std::vector<PositionFactor> factors;
};

Drive make_drive(unsigned seed, double noise) {
  Drive drive;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Pose<3> T = Pose<3>::Identity();
  T.translation() = Eigen::Vector3d(120, -40, 7);
  T.linear() = Eigen::AngleAxisd(2.1, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  Pose<3> step = Pose<3>::Identity();
  step.translation().x() = 3;
  step.linear() = Eigen::AngleAxisd(0.015, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  geometry::Vector6 variance;
  variance << 1e-6, 1e-6, 1e-6, 1e-4, 1e-4, 1e-4;
  const geometry::Matrix6 covariance = variance.asDiagonal();
  for (size_t k = 0; k < 100; ++k) {
    drive.truth.push_back(T);
    if (k == 0) {
      drive.graph.poses.push_back(Pose<3>::Identity());
    } else {
      geometry::Vector6 error;
      for (int i = 0; i < 6; ++i) error[i] = std::sqrt(variance[i]) * normal(random);
      const Pose<3> measured = geometry::exp(error) * step;
      drive.graph.edges.push_back(
          {k - 1, k, measured, edge_information(measured, covariance), false});
      drive.graph.poses.push_back(drive.graph.poses.back() * measured);
    }
    if (k % 4 == 2) {
      PositionFactor factor;
      factor.pose = k;
      factor.point = Eigen::Vector3d(0.7, 0, 0);
      factor.position = T * factor.point;
      for (double& value : factor.position) value += noise * normal(random);
      factor.sigma.setConstant(noise);
      drive.factors.push_back(factor);
    }
    T = T * step;
  }
  return drive;
}

double rms_error(const PositionFit& fit, const std::vector<Pose<3>>& truth) {
  double sum = 0;
  for (size_t k = 0; k < truth.size(); ++k) {
    sum += (fit.graph.poses[k + 1].translation() - truth[k].translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

TEST(PositionFactors, PutTheKeyframesOnTheMap) {
  const Drive drive = make_drive(1, 0.5);
  const PositionFit fit = fit_positions(drive.graph, drive.factors);
  ASSERT_TRUE(fit.usable()) << fit.reason;
  EXPECT_LT(rms_error(fit, drive.truth), 0.5);
  EXPECT_NEAR(fit.rms, 0.5 * std::sqrt(2), 0.25);
  EXPECT_EQ(fit.graph.poses.size(), drive.truth.size() + 1);
}

// Fixes beside tall houses are 60 m off: they are left out, and change nothing by more than noise.
TEST(PositionFactors, LeaveOutFixesThatContradict) {
  Drive drive = make_drive(2, 0.5);
  for (size_t i = 5; i < drive.factors.size(); i += 4) {
    drive.factors[i].position += Eigen::Vector3d(60, -20, 5);
  }
  const PositionFit fit = fit_positions(drive.graph, drive.factors);
  ASSERT_TRUE(fit.usable()) << fit.reason;
  for (size_t i = 0; i < drive.factors.size(); ++i) {
    EXPECT_EQ(fit.accepted[i] != 0, !(i >= 5 && i % 4 == 1)) << i;
  }
  EXPECT_LT(rms_error(fit, drive.truth), 0.5);
}

TEST(PositionFactors, SayWhyThereIsNoGeoreference) {
  Drive drive = make_drive(3, 0.5);
  EXPECT_EQ(fit_positions(drive.graph, {}).reason, "no positions");
  const std::vector<PositionFactor> few(drive.factors.begin(), drive.factors.begin() + 3);
  EXPECT_EQ(fit_positions(drive.graph, few).reason, "too few positions");
  std::vector<PositionFactor> standing = drive.factors;
  for (PositionFactor& factor : standing) factor.position = standing.front().position;
  EXPECT_EQ(fit_positions(drive.graph, standing).reason,
            "the positions are too close together to give a heading");
}

}  // namespace
}  // namespace infuse::mapping

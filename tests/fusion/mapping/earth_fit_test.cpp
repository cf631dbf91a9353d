#include "fusion/mapping/earth_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "drivers/measurement/angles.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::mapping {
namespace {

/// Truth: a bend of 300 m in a map whose axes odometry does not know; the odometry drifts.
struct Drive {
  std::vector<Pose<3>> truth;
  PoseGraph<3> graph;
  std::vector<PositionFactor> factors;
};

Drive make_drive(unsigned seed, double noise, double bend = 0.015) {
  Drive drive;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Pose<3> T = Pose<3>::Identity();
  T.translation() = Eigen::Vector3d(120, -40, 7);
  T.linear() = Eigen::AngleAxisd(2.1, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  Pose<3> step = Pose<3>::Identity();
  step.translation().x() = 3;
  step.linear() = Eigen::AngleAxisd(bend, Eigen::Vector3d::UnitZ()).toRotationMatrix();
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

double rms_error(const EarthFit& fit, const std::vector<Pose<3>>& truth) {
  double sum = 0;
  for (size_t k = 0; k < truth.size(); ++k) {
    sum += (fit.graph.poses[k + 1].translation() - truth[k].translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

TEST(EarthFit, PutTheKeyframesOnTheMap) {
  const Drive drive = make_drive(1, 0.5);
  const EarthFit fit = fit_to_earth(drive.graph, drive.factors);
  ASSERT_TRUE(fit.georeferenced()) << fit.position_reason;
  EXPECT_LT(rms_error(fit, drive.truth), 0.5);
  EXPECT_NEAR(fit.rms, 0.5 * std::sqrt(2), 0.25);
  EXPECT_EQ(fit.graph.poses.size(), drive.truth.size() + 1);
}

// Fixes beside tall houses are 60 m off: they are left out, and change nothing by more than noise.
TEST(EarthFit, LeaveOutFixesThatContradict) {
  Drive drive = make_drive(2, 0.5);
  for (size_t i = 5; i < drive.factors.size(); i += 4) {
    drive.factors[i].position += Eigen::Vector3d(60, -20, 5);
  }
  const EarthFit fit = fit_to_earth(drive.graph, drive.factors);
  ASSERT_TRUE(fit.georeferenced()) << fit.position_reason;
  for (size_t i = 0; i < drive.factors.size(); ++i) {
    EXPECT_EQ(fit.accepted[i] != 0, !(i >= 5 && i % 4 == 1)) << i;
  }
  EXPECT_LT(rms_error(fit, drive.truth), 0.5);
}

/// Largest angle between the z axes of the keyframes and those of the truth, rad.
double worst_tilt(const EarthFit& fit, const std::vector<Pose<3>>& truth) {
  double worst = 0;
  for (size_t k = 0; k < truth.size(); ++k) {
    const double cosine = fit.graph.poses[k + 1].linear().col(2).dot(truth[k].linear().col(2));
    worst = std::max(worst, std::acos(std::min(cosine, 1.0)));
  }
  return worst;
}

// The roll about a line of positions is not in them: the map lay on its side.
TEST(EarthFit, KeepsAStraightDriveUpright) {
  for (unsigned seed = 4; seed < 14; ++seed) {
    const Drive drive = make_drive(seed, 0.5, 0);
    const EarthFit fit = fit_to_earth(drive.graph, drive.factors);
    ASSERT_TRUE(fit.georeferenced()) << fit.position_reason;
    EXPECT_LT(worst_tilt(fit, drive.truth), 3 * fit.tilt_sigma) << seed;
    EXPECT_LT(worst_tilt(fit, drive.truth), 2 * kDegree) << seed;
    EXPECT_LT(fit.tilt_sigma, 2 * kDegree);
  }
}

// The odometry began on its side; without positions the place and heading of the first keyframe
// stay.
TEST(EarthFit, IsUprightWithoutPositions) {
  Drive drive = make_drive(14, 0.5);
  const Pose<3> tilt(Eigen::AngleAxisd(0.5, Eigen::Vector3d(0.8, 0.6, 0)));
  for (Pose<3>& pose : drive.graph.poses) pose = tilt * pose;
  const EarthFit fit = fit_to_earth(drive.graph, {});
  ASSERT_TRUE(fit.usable());
  EXPECT_FALSE(fit.georeferenced());
  for (const Pose<3>& pose : fit.graph.poses) {
    EXPECT_LT(std::acos(std::min(pose.linear()(2, 2), 1.0)), 3 * fit.tilt_sigma);
  }
  EXPECT_LT((fit.graph.poses[1].translation() - drive.graph.poses[0].translation()).norm(), 0.01);
}

// The stated standard deviation of the tilt is that of the estimate, where slopes are as stated.
TEST(EarthFit, StatesHowUprightItIs) {
  std::mt19937 random(15);
  std::normal_distribution<double> normal;
  const EarthFitOptions options;
  double sum = 0;
  constexpr int kDrives = 100;
  for (int i = 0; i < kDrives; ++i) {
    Drive drive = make_drive(20 + static_cast<unsigned>(i), 0.5, 0);
    // The whole road leans.
    const Pose<3> slope(
        Eigen::AngleAxisd(options.pitch_sigma * normal(random), Eigen::Vector3d::UnitY()) *
        Eigen::AngleAxisd(options.roll_sigma * normal(random), Eigen::Vector3d::UnitX()));
    for (Pose<3>& pose : drive.truth) pose = pose * slope;
    const EarthFit fit = fit_to_earth(drive.graph, {}, options);
    const Eigen::Vector3d up = drive.truth[0].linear().transpose() * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d found =
        fit.graph.poses[1].linear().transpose() * Eigen::Vector3d::UnitZ();
    sum += (up - found).head<2>().squaredNorm() / (fit.tilt_sigma * fit.tilt_sigma);
  }
  // (1.4² + 1.7²) / 1.7² for the stated worse one of two directions, 1.3 for the slopes'
  // correlation over 300 m that is one here; ± 3 standard deviations of 100 draws.
  EXPECT_NEAR(sum / kDrives, 2.2, 0.7);
}

TEST(EarthFit, SayWhyThereIsNoGeoreference) {
  Drive drive = make_drive(3, 0.5);
  EXPECT_EQ(fit_to_earth(drive.graph, {}).position_reason, "no positions");
  const std::vector<PositionFactor> few(drive.factors.begin(), drive.factors.begin() + 3);
  EXPECT_EQ(fit_to_earth(drive.graph, few).position_reason, "too few positions");
  std::vector<PositionFactor> standing = drive.factors;
  for (PositionFactor& factor : standing) factor.position = standing.front().position;
  EXPECT_EQ(fit_to_earth(drive.graph, standing).position_reason,
            "the positions are too close together to give a heading");
}

}  // namespace
}  // namespace infuse::mapping

#include "fusion/calibration/uncertainty.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/maximize.hpp"
#include "fusion/calibration/named_measures.hpp"
#include "fusion/calibration/scene_similarity.hpp"
#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

using geometry::Matrix6;
using testing::HasSubstr;

/// Uncertainty at the maximum near the truth, of scenes with a similarity.
Uncertainty uncertainty_of(const std::vector<Scene>& scenes, const Eigen::MatrixXd& similarity) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  const std::vector<TermOptions>& terms = named_measures().front().terms;
  const BlurredImages images(scenes, drive.cameras, terms, ImageBlur::in_angle(1));
  const VisiblePoints points = select_visible(scenes, drive.cameras, drive.T_camera_lidar, {});
  Objective objective(points, images, drive.cameras, scenes, terms);
  const Eigen::Isometry3d best = maximize(objective, drive.T_camera_lidar, {}).T_refcam_lidar;
  return estimate_uncertainty(objective, best, similarity);
}

std::vector<Scene> first_scenes(ptrdiff_t count) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  return {drive.scenes.begin(), drive.scenes.begin() + count};
}

TEST(CurvatureSteps, ChangeTheSamplesEvenly) {
  // A weak direction: rotation about y that a translation along x makes up for, at a range of 10 m.
  constexpr double kRange = 10;
  geometry::Vector6 unit, weak;
  unit << Eigen::Vector3d::Ones(), Eigen::Vector3d::Constant(kRange);
  weak << 0, 1, 0, 1, 0, 0;
  weak.normalize();
  const auto information_of = [&](double share) -> Matrix6 {
    const Matrix6 scaled = Matrix6::Identity() - (1 - share) * weak * weak.transpose();
    return unit.cwiseInverse().asDiagonal() * scaled * unit.cwiseInverse().asDiagonal();
  };
  const auto change = [&](const Matrix6& steps, double share) {
    return (steps.transpose() * information_of(share) * steps).diagonal().cwiseSqrt().eval();
  };
  const double mean = std::sqrt((5 + 0.1) / 6);
  const auto even = change(curvature_steps(information_of(0.1), kRange), 0.1);
  EXPECT_NEAR(even.minCoeff(), mean, 1e-9);
  EXPECT_NEAR(even.maxCoeff(), mean, 1e-9);
  // The step along a direction that nothing determines stays within four times the others.
  const Matrix6 bounded = curvature_steps(information_of(0), kRange);
  const Matrix6 in_units = unit.cwiseInverse().asDiagonal() * bounded;
  EXPECT_NEAR(in_units.colwise().norm().maxCoeff(), 4, 1e-9);
}

TEST(PoseCurvature, DoesNotDependOnTheDirectionsOfTheSteps) {
  const painted::Drive& drive = painted::twelve_scene_drive();
  const std::vector<TermOptions>& terms = named_measures().front().terms;
  const BlurredImages images(drive.scenes, drive.cameras, terms, ImageBlur::in_angle(4));
  const VisiblePoints points =
      select_visible(drive.scenes, drive.cameras, drive.T_camera_lidar, {});
  Objective objective(points, images, drive.cameras, drive.scenes, terms);
  const double range = objective.median_range();
  geometry::Vector6 unit;
  unit << Eigen::Vector3d::Ones(), Eigen::Vector3d::Constant(range);
  const Matrix6 axes = 1e-3 * Matrix6(unit.asDiagonal());
  geometry::Vector6 mirror;  // Householder: an orthonormal basis with all axes mixed
  mirror << 1, 2, -1, 1, -2, 3;
  mirror.normalize();
  const Matrix6 mixed = axes * (Matrix6::Identity() - 2 * mirror * mirror.transpose());
  const Matrix6 one = pose_curvature(objective, drive.T_camera_lidar, axes);
  const Matrix6 other = pose_curvature(objective, drive.T_camera_lidar, mixed);
  const Matrix6 apart = unit.asDiagonal() * (one - other) * unit.asDiagonal();
  const Matrix6 scaled = unit.asDiagonal() * one * unit.asDiagonal();
  EXPECT_LT(apart.norm(), 0.05 * scaled.norm());
}

TEST(Uncertainty, IsPositiveDefiniteForThreeScenes) {
  const Uncertainty few = uncertainty_of(first_scenes(3), {});
  ASSERT_TRUE(few.usable()) << few.reason;
  EXPECT_EQ(few.effective_scenes, 3);
  geometry::Vector6 unit;
  unit << Eigen::Vector3d::Constant(1), Eigen::Vector3d::Constant(0.1);
  const Matrix6 scaled = unit.asDiagonal() * few.covariance * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(scaled);
  EXPECT_GT(eigen.eigenvalues()(0), 1e-4 * eigen.eigenvalues()(5));
}

TEST(Uncertainty, ScenesThatAreAlikeAddLittle) {
  const Uncertainty apart = uncertainty_of(first_scenes(12), {});
  Eigen::MatrixXd similarity = Eigen::MatrixXd::Identity(12, 12);
  for (int k = 0; k < 12; k += 2) similarity(k, k + 1) = similarity(k + 1, k) = 1;
  const Uncertainty alike = uncertainty_of(first_scenes(12), similarity);
  EXPECT_EQ(alike.effective_scenes, 6);
  const auto scatter = [](const Uncertainty& of) -> Matrix6 {
    return of.covariance - of.bias_covariance;
  };
  EXPECT_GT(scatter(alike).trace(), 1.5 * scatter(apart).trace());
}

// A bias of all bands alike is another principal point: the pose follows it as it follows that.
TEST(Uncertainty, ABiasOfAllBandsIsThatOfThePrincipalPoint) {
  const Uncertainty found = uncertainty_of(first_scenes(12), {});
  ASSERT_TRUE(found.usable()) << found.reason;
  const SceneInformation all = total_information(found.scene_information);
  ASSERT_EQ(found.bias_information.cols(), 8);
  for (Eigen::Index across = 0; across < 2; ++across) {
    SceneGradient sum = SceneGradient::Zero();
    for (Eigen::Index k = across; k < 8; k += 2) sum += found.bias_information.col(k);
    const SceneGradient centre = all.col(7 + across);
    EXPECT_LT((sum - centre).norm(), 1e-6 * centre.norm());
  }
  // One pixel turns the camera by about 1 / f; half a pixel in some bands by less than half of it.
  const double turned = std::sqrt(found.bias_covariance(1, 1));
  EXPECT_GT(turned, 0.1 / 330);
  EXPECT_LT(turned, 1 / 330.0);
}

TEST(Uncertainty, TheBiasDoesNotShrinkWithTheNumberOfScenes) {
  const Uncertainty few = uncertainty_of(first_scenes(6), {});
  const Uncertainty many = uncertainty_of(first_scenes(12), {});
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    const double ratio = many.bias_covariance(axis, axis) / few.bias_covariance(axis, axis);
    EXPECT_GT(ratio, 0.5) << axis;
    EXPECT_LT(ratio, 2) << axis;
  }
}

// Contributions of weighted scenes, alike in groups: the scatter about their mean, times the
// factor, is the variance of their sum.
TEST(ScatterFactor, MakesTheScatterUnbiased) {
  Eigen::MatrixXd similarity = Eigen::MatrixXd::Identity(8, 8);
  similarity.topLeftCorner(4, 4).setConstant(0.6);
  similarity.diagonal().setOnes();
  const Eigen::VectorXd weights = scene_weights(similarity);
  const Eigen::MatrixXd root = similarity.llt().matrixL();
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  constexpr int kDraws = 200'000;
  double scatter = 0, squares = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Eigen::VectorXd noise(8);
    for (double& one : noise) one = normal(random);
    const Eigen::VectorXd pulls = weights.cwiseProduct(root * noise);
    scatter += (pulls.array() - pulls.mean()).square().sum() / kDraws;
    squares += pulls.sum() * pulls.sum() / kDraws;
  }
  EXPECT_NEAR(scatter_factor(design_effect(similarity, weights), 8) * scatter / squares, 1, 0.02);
}

TEST(Uncertainty, OnePlaceIsRefusedHoweverManyScenes) {
  const Uncertainty one = uncertainty_of(first_scenes(12), Eigen::MatrixXd::Ones(12, 12));
  EXPECT_FALSE(one.usable());
  EXPECT_THAT(one.reason, HasSubstr("12 scenes of nearly the same place count as 1.0"));
}

TEST(DescribeImprecision, NamesTheWorstDirection) {
  Matrix6 covariance = Matrix6::Zero();
  covariance.diagonal() << 1e-8, 4e-6, 1e-8, 1e-6, 1e-6, 1e-4;  // 0.115 degrees, 1 cm
  EXPECT_EQ(describe_imprecision(covariance, 0.2 * kDegree, 0.05), "");
  EXPECT_THAT(describe_imprecision(covariance, 0.1 * kDegree, 0.05), HasSubstr("rotation about"));
  EXPECT_THAT(describe_imprecision(covariance, 0.2 * kDegree, 0.005),
              HasSubstr("along (0.0, 0.0, 1.0) in camera axes is 1 cm"));
}

}  // namespace
}  // namespace infuse::calibration

#include "fusion/geometry/rigid_motion.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace infuse::geometry {
namespace {

/// Matrix exponential by its power series with scaling and squaring: independent of the closed
/// form.
Eigen::Matrix4d series_exp(const Vector6& twist) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  A.topLeftCorner<3, 3>() = skew(twist.head<3>());
  A.topRightCorner<3, 1>() = twist.tail<3>();
  A /= 1024;
  Eigen::Matrix4d sum = Eigen::Matrix4d::Identity(), term = sum;
  for (int n = 1; n < 20; ++n) {
    term = term * A / n;
    sum += term;
  }
  for (int i = 0; i < 10; ++i) sum = (sum * sum).eval();
  return sum;
}

Vector6 random_twist(std::mt19937_64& random, double angle) {
  std::normal_distribution<double> normal;
  Vector6 twist;
  for (int i = 0; i < 6; ++i) twist[i] = normal(random);
  twist.head<3>() *= angle / twist.head<3>().norm();
  return twist;
}

const double kAngles[] = {1e-12, 1e-7, 1e-4, 0.05, 0.0999, 0.1001, 0.7, 2.0, 3.0, 3.1415};

TEST(RigidMotion, ExpEqualsTheMatrixExponential) {
  std::mt19937_64 random(1);
  for (const double angle : kAngles) {
    const Vector6 twist = random_twist(random, angle);
    EXPECT_LT((exp(twist).matrix() - series_exp(twist)).cwiseAbs().maxCoeff(), 1e-11) << angle;
  }
}

TEST(RigidMotion, ExpOfAScrewMotionIsKnown) {
  Vector6 quarter_turn;
  quarter_turn << 0, 0, std::numbers::pi / 2, std::numbers::pi / 2, 0, 3;
  const Eigen::Isometry3d T = exp(quarter_turn);  // a quarter circle of radius 1 to the left
  EXPECT_LT((T.translation() - Eigen::Vector3d(1, 1, 3)).norm(), 1e-14);
  EXPECT_LT((T.linear() * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-14);
}

TEST(RigidMotion, LogInvertsExp) {
  std::mt19937_64 random(2);
  for (const double angle : kAngles) {
    const Vector6 twist = random_twist(random, angle);
    EXPECT_LT((log(exp(twist)) - twist).cwiseAbs().maxCoeff(), 1e-9) << angle;
  }
}

TEST(RigidMotion, LogOfAHalfTurnIsAHalfTurn) {
  const Eigen::Matrix3d R = Eigen::Vector3d(-1, -1, 1).asDiagonal();
  const Eigen::Vector3d w = rotation_log(R);
  EXPECT_NEAR(w.norm(), std::numbers::pi, 1e-12);
  EXPECT_LT((rotation_exp(w) - R).norm(), 1e-12);
}

TEST(RigidMotion, AdjointTransformsATwist) {
  std::mt19937_64 random(3);
  const Eigen::Isometry3d T = exp(random_twist(random, 1.3));
  const Vector6 twist = random_twist(random, 0.4);
  const Eigen::Isometry3d direct = T * exp(twist) * T.inverse();
  EXPECT_LT((exp(adjoint(T) * twist).matrix() - direct.matrix()).norm(), 1e-12);
}

TEST(RigidMotion, LeftJacobianIsTheDerivativeOfExp) {
  std::mt19937_64 random(4);
  for (const double angle : {1e-6, 0.05, 0.0999, 0.1001, 0.9, 2.5}) {
    const Vector6 twist = random_twist(random, angle);
    const Matrix6 J = left_jacobian(twist);
    constexpr double kStep = 1e-5;
    for (int i = 0; i < 6; ++i) {
      Vector6 step = Vector6::Zero();
      step[i] = kStep;
      const Eigen::Isometry3d inverse = exp(twist).inverse();
      const Vector6 numeric =
          (log(exp(twist + step) * inverse) - log(exp(twist - step) * inverse)) / (2 * kStep);
      EXPECT_LT((J.col(i) - numeric).norm(), 1e-8) << angle << " " << i;
    }
    EXPECT_LT((J * left_jacobian_inverse(twist) - Matrix6::Identity()).norm(), 1e-10) << angle;
  }
}

TEST(RigidMotion, InterpolatesAtConstantTwist) {
  std::mt19937_64 random(5);
  const Eigen::Isometry3d A = exp(random_twist(random, 1.0));
  const Vector6 body_twist = random_twist(random, 0.8);
  const Eigen::Isometry3d B = A * exp(body_twist);
  for (const double u : {0.0, 0.25, 0.5, 1.0, 1.5}) {
    const Eigen::Isometry3d expected = A * exp(u * body_twist);
    EXPECT_LT((interpolate(A, B, u).matrix() - expected.matrix()).norm(), 1e-12) << u;
  }
}

// Samples of a noisy motion, transformed to another frame: their covariance is the transformed one.
TEST(RigidMotion, TransformsCovarianceLikeSamples) {
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  const Eigen::Isometry3d T = exp(random_twist(random, 0.7));
  Vector6 sigma;
  sigma << 1e-3, 2e-3, 5e-4, 3e-3, 1e-3, 2e-3;
  const Matrix6 expected = transform_covariance(T, sigma.cwiseAbs2().asDiagonal());
  Matrix6 sampled = Matrix6::Zero();
  constexpr int kSamples = 40000;
  for (int n = 0; n < kSamples; ++n) {
    Vector6 xi;
    for (int i = 0; i < 6; ++i) xi[i] = sigma[i] * normal(random);
    const Vector6 moved = log(T * exp(xi) * T.inverse());
    sampled += moved * moved.transpose() / kSamples;
  }
  EXPECT_LT((sampled - expected).norm(), 0.03 * expected.norm());
}

}  // namespace
}  // namespace infuse::geometry

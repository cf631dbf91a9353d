#include "fusion/geometry/camera_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fusion/geometry/project_points.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::geometry {
namespace {

using Model = CameraIntrinsics::Model;

CameraIntrinsics pinhole() {
  return {Model::kPinhole, 1280,  960,    820.5,
          818.25,          641.5, 478.75, {-0.28, 0.09, 7e-4, -4e-4, -0.012}};
}
CameraIntrinsics fisheye() {
  return {Model::kFisheye, 1600, 1200, 430.0, 431.5, 801.0, 596.5, {0.04, -0.01, 0.004, -0.0012}};
}

/// Formulas of OpenCV's documentation.
Eigen::Vector2d project_by_opencv_formulas(const CameraIntrinsics& c, const Eigen::Vector3d& P) {
  const auto& k = c.distortion;
  const double a = P.x() / P.z(), b = P.y() / P.z();
  const double r = std::sqrt(a * a + b * b);
  double u, v;
  if (c.model == Model::kPinhole) {
    const double f = 1 + k[0] * std::pow(r, 2) + k[1] * std::pow(r, 4) + k[4] * std::pow(r, 6);
    u = a * f + 2 * k[2] * a * b + k[3] * (r * r + 2 * a * a);
    v = b * f + k[2] * (r * r + 2 * b * b) + 2 * k[3] * a * b;
  } else {
    const double t = std::atan(r);
    const double d = t * (1 + k[0] * std::pow(t, 2) + k[1] * std::pow(t, 4) +
                          k[2] * std::pow(t, 6) + k[3] * std::pow(t, 8));
    u = d / r * a;
    v = d / r * b;
  }
  return {c.fx * u + c.cx, c.fy * v + c.cy};
}

Eigen::Vector3d random_point(std::mt19937_64& random, double spread) {
  std::uniform_real_distribution<double> uniform(-spread, spread), depth(1, 40);
  const double z = depth(random);
  return {uniform(random) * z, uniform(random) * z, z};
}

class CameraModels : public testing::TestWithParam<CameraIntrinsics> {};
INSTANTIATE_TEST_SUITE_P(Both, CameraModels, testing::Values(pinhole(), fisheye()),
                         [](const auto& camera) {
                           return camera.param.model == Model::kPinhole ? "Pinhole" : "Fisheye";
                         });

TEST_P(CameraModels, ProjectAgreesWithOpenCvFormulas) {
  std::mt19937_64 random(1);
  const CameraModel camera(GetParam());
  for (int n = 0; n < 200; ++n) {
    const Eigen::Vector3d point = random_point(random, 0.75);
    const auto pixel = camera.project(point);
    ASSERT_TRUE(pixel);
    EXPECT_LT((*pixel - project_by_opencv_formulas(GetParam(), point)).norm(), 1e-9);
  }
}

TEST_P(CameraModels, UnprojectUndoesProject) {
  std::mt19937_64 random(2);
  const CameraModel camera(GetParam());
  for (int n = 0; n < 300; ++n) {
    const Eigen::Vector3d point = random_point(random, 0.85);
    const auto direction = camera.unproject(camera.project(point).value());
    ASSERT_TRUE(direction) << point.transpose();
    EXPECT_LT((*direction - point.normalized()).norm(), 1e-10) << point.transpose();
  }
  const auto axis = camera.unproject({GetParam().cx, GetParam().cy});
  ASSERT_TRUE(axis);
  EXPECT_LT((*axis - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_FALSE(camera.unproject({1e7, 3}));
  EXPECT_FALSE(camera.unproject({std::nan(""), 3}));
}

TEST_P(CameraModels, DerivativesAgreeWithDifferences) {
  std::mt19937_64 random(3);
  const CameraModel camera(GetParam());
  constexpr double kStep = 1e-6;
  for (int n = 0; n < 100; ++n) {
    const Eigen::Vector3d point = n == 0 ? Eigen::Vector3d(0, 0, 5) : random_point(random, 0.7);
    const auto derivatives = camera.project_with_derivatives(point);
    ASSERT_TRUE(derivatives);
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
      const Eigen::Vector2d numeric =
          (*camera.project(point + step) - *camera.project(point - step)) / (2 * kStep);
      EXPECT_LT((derivatives->by_point.col(i) - numeric).norm(), 1e-4) << point.transpose();
    }
    for (int i = 0; i < 6; ++i) {
      const Vector6 step = kStep * Vector6::Unit(i);
      const Eigen::Vector2d numeric =
          (*camera.project(exp(step) * point) - *camera.project(exp(-step) * point)) / (2 * kStep);
      EXPECT_LT((derivatives->by_pose.col(i) - numeric).norm(), 1e-3) << point.transpose();
    }
  }
}

TEST(CameraModel, DoesNotFoldBackPointsFarOutside) {
  const CameraModel camera(pinhole());
  EXPECT_FALSE(camera.project({1, 1, -3}));
  EXPECT_FALSE(camera.project({1, 1, 0}));
  EXPECT_FALSE(camera.project({std::nan(""), 1, 2}));
  // By the polynomial alone this direction, 73° off the axis, would project into the image.
  const Eigen::Vector3d wide(3.2, 0.2, 1);
  CameraIntrinsics folding = pinhole();
  folding.distortion = {-0.10, 0, 0, 0, 0};
  ASSERT_TRUE(CameraModel(folding).in_image(project_by_opencv_formulas(folding, wide)));
  EXPECT_FALSE(CameraModel(folding).project(wide));
  // The radius r (1 − 0.1 r²) increases up to r² = 10/3.
  EXPECT_NEAR(CameraModel(folding).limit(), 10.0 / 3, 0.02);
}

TEST(CameraModel, FisheyeProjectsPointsBehindTheImagePlane) {
  CameraIntrinsics ideal = fisheye();
  ideal.distortion = {};
  const CameraModel camera(ideal);
  const double angle = 2.0;  // 115°
  const auto pixel = camera.project({std::sin(angle), 0, std::cos(angle)});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x(), ideal.cx + ideal.fx * angle, 1e-9);
  const auto direction = camera.unproject(*pixel);
  ASSERT_TRUE(direction);
  EXPECT_NEAR(direction->z(), std::cos(angle), 1e-12);
}

TEST(CameraModel, ImageEndsHalfAPixelBeyondTheLastCentre) {
  const CameraModel camera(pinhole());
  EXPECT_TRUE(camera.in_image({-0.5, -0.5}));
  EXPECT_TRUE(camera.in_image({1279.4, 959.4}));
  EXPECT_FALSE(camera.in_image({1279.5, 0}));
  EXPECT_FALSE(camera.in_image({0, -0.51}));
  EXPECT_FALSE(camera.in_image({std::nan(""), 0}));
}

TEST_P(CameraModels, BatchProjectionAgreesWithSinglePoints) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<float> uniform(-30, 30);
  const CameraModel camera(GetParam());
  Vector6 twist;
  twist << 1.2, -1.2, 1.2, 0.1, -0.2, 0.3;
  const Eigen::Isometry3d T = exp(twist);
  constexpr size_t kCount = 10007;
  std::vector<float> x(kCount), y(kCount), z(kCount), u(kCount), v(kCount), depth(kCount);
  for (size_t n = 0; n < kCount; ++n) {
    x[n] = uniform(random);
    y[n] = uniform(random);
    z[n] = uniform(random);
  }
  project_points(camera, T, {x, y, z}, {u, v, depth});
  size_t seen = 0;
  for (size_t n = 0; n < kCount; ++n) {
    const Eigen::Vector3d point = T * Eigen::Vector3d(x[n], y[n], z[n]);
    if (point.norm() < 1) continue;
    EXPECT_NEAR(depth[n], point.z(), 1e-4);
    const auto pixel = camera.project(point);
    if (!pixel || !camera.in_image(*pixel)) {
      EXPECT_FALSE(camera.in_image({u[n], v[n]}) &&
                   (!pixel || (Eigen::Vector2d(u[n], v[n]) - *pixel).norm() > 0.01));
      continue;
    }
    ++seen;
    EXPECT_NEAR(u[n], pixel->x(), 0.01);
    EXPECT_NEAR(v[n], pixel->y(), 0.01);
  }
  EXPECT_GT(seen, 500u);
}

// Any split of the input gives the same bytes: vector body and scalar tail compute the same.
TEST_P(CameraModels, BatchProjectionDoesNotDependOnTheNumberOfPoints) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<float> uniform(-30, 30);
  const CameraModel camera(GetParam());
  constexpr size_t kCount = 77;
  std::vector<float> x(kCount), y(kCount), z(kCount);
  for (size_t n = 0; n < kCount; ++n) {
    x[n] = uniform(random);
    y[n] = uniform(random);
    z[n] = uniform(random);
  }
  std::vector<float> u(kCount), v(kCount), depth(kCount);
  project_points(camera, Eigen::Isometry3d::Identity(), {x, y, z}, {u, v, depth});
  for (size_t n = 0; n < kCount; ++n) {
    float u1, v1, depth1;
    project_points(camera, Eigen::Isometry3d::Identity(), {{&x[n], 1}, {&y[n], 1}, {&z[n], 1}},
                   {{&u1, 1}, {&v1, 1}, {&depth1, 1}});
    EXPECT_TRUE(u1 == u[n] || (std::isnan(u1) && std::isnan(u[n])));
    EXPECT_TRUE(v1 == v[n] || (std::isnan(v1) && std::isnan(v[n])));
    EXPECT_EQ(depth1, depth[n]);
  }
}

}  // namespace
}  // namespace infuse::geometry

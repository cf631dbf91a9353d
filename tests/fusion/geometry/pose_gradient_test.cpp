#include "fusion/geometry/pose_gradient.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace infuse::geometry {
namespace {

struct Points {
  std::vector<float> x, y, z, by_u, by_v;
};

Points draw_points(size_t n) {
  std::mt19937_64 random(5);
  const auto draw = [&](double low, double high) {
    return static_cast<float>(low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53);
  };
  Points points;
  for (size_t i = 0; i < n; ++i) {
    const float depth = draw(3, 40);
    points.x.push_back(draw(-0.5, 0.5) * depth);
    points.y.push_back(draw(-0.4, 0.4) * depth);
    points.z.push_back(depth);
    const bool zero_gradient = i % 7 == 0;
    points.by_u.push_back(zero_gradient ? 0 : draw(-1, 1));
    points.by_v.push_back(zero_gradient ? 0 : draw(-1, 1));
  }
  return points;
}

void expect_sum_of_points(const CameraIntrinsics& intrinsics, size_t n) {
  const CameraModel camera(intrinsics);
  Vector6 xi;
  xi << 0.02, -0.03, 0.05, 0.2, -0.1, 0.3;
  const Eigen::Isometry3d T = exp(xi);
  const Points points = draw_points(n);
  Vector6 sum = Vector6::Zero();
  double size = 1e-9;
  for (size_t i = 0; i < n; ++i) {
    const auto one =
        camera.project_with_derivatives(T * Eigen::Vector3d(points.x[i], points.y[i], points.z[i]));
    ASSERT_TRUE(one);
    const Vector6 part = one->by_pose.transpose() * Eigen::Vector2d(points.by_u[i], points.by_v[i]);
    sum += part;
    size += part.norm();
  }
  const Vector6 fast =
      pose_gradient(camera, T, {points.x, points.y, points.z}, points.by_u, points.by_v);
  EXPECT_LT((fast - sum).norm(), 1e-5 * size) << fast.transpose() << "\n" << sum.transpose();
}

CameraIntrinsics small_pinhole() {
  return {.width = 640, .height = 480, .fx = 500, .fy = 510, .cx = 320, .cy = 240};
}

TEST(PoseGradient, EqualsTheSumOverThePoints) {
  for (const size_t n : {0, 1, 15, 16, 17, 1024, 3000}) expect_sum_of_points(small_pinhole(), n);
}

TEST(PoseGradient, IncludesDistortion) {
  CameraIntrinsics intrinsics = small_pinhole();
  intrinsics.distortion = {-0.15, 0.03, 0.002, -0.001, 0.004};
  expect_sum_of_points(intrinsics, 1500);
}

TEST(PoseGradient, WorksForAFisheye) {
  CameraIntrinsics intrinsics = small_pinhole();
  intrinsics.model = CameraIntrinsics::Model::kFisheye;
  intrinsics.distortion = {0.03, -0.01, 0.002, -0.001, 0};
  expect_sum_of_points(intrinsics, 500);
}

TEST(PoseGradient, IgnoresUnprojectedPointsWithZeroDerivatives) {
  Points points = draw_points(40);
  const auto full = pose_gradient(CameraModel(small_pinhole()), Eigen::Isometry3d::Identity(),
                                  {points.x, points.y, points.z}, points.by_u, points.by_v);
  for (size_t i = 0; i < 40; i += 7) points.z[i] = 0;  // in the image plane
  const auto less = pose_gradient(CameraModel(small_pinhole()), Eigen::Isometry3d::Identity(),
                                  {points.x, points.y, points.z}, points.by_u, points.by_v);
  EXPECT_EQ(full, less);
}

}  // namespace
}  // namespace infuse::geometry

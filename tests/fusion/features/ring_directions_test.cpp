#include "fusion/features/ring_directions.hpp"

#include <gtest/gtest.h>

#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::features {
namespace {

/// Camera along x of the lidar, upright, then rotated by ξ.
Eigen::Isometry3d rotated_camera(double rx, double ry, double rz) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  geometry::Vector6 turn;
  turn << rx, ry, rz, 0.3, -0.2, 0.5;
  return geometry::exp(turn) * T;
}

CameraIntrinsics pinhole() {
  CameraIntrinsics camera{.width = 321, .height = 200, .fx = 180, .fy = 170, .cx = 161, .cy = 98};
  camera.distortion = {-0.12, 0.03, 0.0004, -0.0003, 0.0};
  return camera;
}

CameraIntrinsics fisheye() {
  CameraIntrinsics camera{.width = 320, .height = 320, .fx = 90, .fy = 90, .cx = 160, .cy = 160};
  camera.model = CameraIntrinsics::Model::kFisheye;
  camera.distortion = {0.02, -0.004, 0.0, 0.0};
  return camera;
}

/// Direction in which a point a kilometre away, in the middle of a cell, moves as the lidar
/// rotates.
void expect_matches_rotated_points(const CameraIntrinsics& intrinsics, const Eigen::Isometry3d& T) {
  const geometry::CameraModel camera(intrinsics);
  const RingDirections rings = ring_directions(camera, T);
  ASSERT_EQ(rings.columns * rings.rows, static_cast<int>(rings.right.size()));
  int seen = 0;
  for (int row = 0; row < rings.rows; ++row) {
    for (int column = 0; column < rings.columns; ++column) {
      const Eigen::Vector2d pixel(16 * column + 7.5, 16 * row + 7.5);
      const auto along = camera.unproject(pixel);
      if (!along) continue;
      const Eigen::Vector3d far = T.inverse() * (1000 * *along);
      const Eigen::Vector3d turned = Eigen::AngleAxisd(1e-4, Eigen::Vector3d::UnitZ()) * far;
      const auto there = camera.project(T * turned);
      const auto here = camera.project(T * far);
      if (!there || !here || (*there - *here).norm() < 1e-3) continue;
      const Eigen::Vector2d direction = (*there - *here).normalized();
      const auto at = static_cast<size_t>(row * rings.columns + column);
      EXPECT_NEAR(rings.right[at], direction.x(), 5e-3) << column << ", " << row;
      EXPECT_NEAR(rings.down[at], direction.y(), 5e-3) << column << ", " << row;
      ++seen;
    }
  }
  EXPECT_GT(seen, rings.columns * rings.rows / 2);
}

TEST(RingDirections, FollowRotatedPoints) {
  for (const auto& intrinsics : {pinhole(), fisheye()}) {
    expect_matches_rotated_points(intrinsics, rotated_camera(0, 0, 0));
    expect_matches_rotated_points(intrinsics, rotated_camera(0, 0, M_PI / 2));
    expect_matches_rotated_points(intrinsics, rotated_camera(0.4, -0.7, 0.3));
    expect_matches_rotated_points(intrinsics, rotated_camera(-1.2, 0.2, 2.0));
  }
}

TEST(RingDirections, AreRowsForAnUprightCamera) {
  const RingDirections rings =
      ring_directions(geometry::CameraModel(pinhole()), rotated_camera(0, 0, 0));
  EXPECT_EQ(rings.columns, 21);
  EXPECT_EQ(rings.rows, 13);
  const auto middle = static_cast<size_t>(6 * rings.columns + 10);
  EXPECT_NEAR(std::abs(rings.right[middle]), 1, 1e-3);
  EXPECT_NEAR(rings.down[middle], 0, 0.02);
}

TEST(RingDirections, AreNoneAlongTheAxis) {
  CameraIntrinsics up = fisheye();
  up.width = up.height = 336;  // 21 cells: one in the middle, around pixel (167.5, 167.5)
  up.cx = up.cy = 167.5;
  const RingDirections rings =
      ring_directions(geometry::CameraModel(up), Eigen::Isometry3d::Identity());
  const auto middle = static_cast<size_t>(10 * rings.columns + 10);
  EXPECT_EQ(rings.right[middle], 0);
  EXPECT_EQ(rings.down[middle], 0);
  EXPECT_NEAR(std::abs(rings.down[middle + 5]), 1, 1e-3);  // around the axis
}

}  // namespace
}  // namespace infuse::features

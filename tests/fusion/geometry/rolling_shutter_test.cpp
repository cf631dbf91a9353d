#include "fusion/geometry/rolling_shutter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace infuse::geometry {
namespace {

constexpr double kReadout = 0.03;  // s

CameraIntrinsics intrinsics() {
  return {.width = 640, .height = 480, .fx = 400, .fy = 400, .cx = 320, .cy = 240};
}

/// A camera that looks along the lidar's x axis.
Eigen::Isometry3d T_camera_lidar() {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  T.translation() = Eigen::Vector3d(0.1, 0.3, -0.2);
  return T;
}

/// The pixel at which the point is when its row is exposed, by the exact motion: brute force.
Eigen::Vector2d seen(const CameraModel& camera, const Vector6& twist, double readout,
                     const Eigen::Vector3d& p) {
  Eigen::Vector2d pixel = *camera.project(T_camera_lidar() * p);
  for (int i = 0; i < 50; ++i) {
    const double row = std::clamp(pixel.y(), 0.0, 479.0);
    const double dt = readout * (row / 479 - 0.5);
    pixel = *camera.project(T_camera_lidar() * exp(-dt * twist) * p);
  }
  return pixel;
}

TEST(RollingShutter, MovedPointsLieWhereTheirRowsSeeThem) {
  const CameraModel camera(intrinsics());
  Vector6 twist;
  twist << 0.02, -0.1, 0.5, 10, 0.3, 0.1;  // a fast turn over a bump
  std::mt19937 random(1);
  std::uniform_real_distribution<float> ahead(6, 40), aside(-0.7F, 0.7F), up(-0.5F, 0.5F);
  std::vector<float> x, y, z;
  for (int i = 0; i < 500; ++i) {
    x.push_back(ahead(random));
    y.push_back(x.back() * aside(random));
    z.push_back(x.back() * up(random));
  }
  for (const double readout : {kReadout, -kReadout}) {
    auto mx = x, my = y, mz = z;
    std::vector<float> u(x.size()), v(x.size()), depth(x.size());
    const RollingShutter shutter{camera, from_seconds(readout), twist};
    shutter.move(T_camera_lidar(), mx, my, mz, {u, v, depth});
    double still = 0, moved = 0;
    for (size_t i = 0; i < x.size(); ++i) {
      const Eigen::Vector3d before(x[i], y[i], z[i]), after(mx[i], my[i], mz[i]);
      const Eigen::Vector2d truth = seen(camera, twist, readout, before);
      still = std::max(still, (*camera.project(T_camera_lidar() * before) - truth).norm());
      moved = std::max(moved, (*camera.project(T_camera_lidar() * after) - truth).norm());
    }
    EXPECT_GT(still, 4);     // pixels
    EXPECT_LT(moved, 0.35);  // the row is that before the move
  }
}

TEST(RollingShutter, PointsThatTheCameraDoesNotProjectStay) {
  const CameraModel camera(intrinsics());
  std::vector<float> x{-5, NAN}, y{1, 0}, z{0, 0}, u(2), v(2), depth(2);
  const RollingShutter shutter{camera, from_seconds(kReadout), Vector6::Ones()};
  shutter.move(T_camera_lidar(), x, y, z, {u, v, depth});
  EXPECT_EQ(x[0], -5);
  EXPECT_EQ(y[0], 1);
}

}  // namespace
}  // namespace infuse::geometry

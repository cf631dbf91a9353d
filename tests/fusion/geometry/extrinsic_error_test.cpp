#include "fusion/geometry/extrinsic_error.hpp"
#include "drivers/measurement/angles.hpp"

#include <gtest/gtest.h>

namespace infuse::geometry {
namespace {

CameraModel camera() {
  CameraIntrinsics intrinsics;
  intrinsics.width = 1000;
  intrinsics.height = 600;
  intrinsics.fx = intrinsics.fy = 800;
  intrinsics.cx = 499.5;
  intrinsics.cy = 299.5;
  return CameraModel(intrinsics);
}

TEST(ExtrinsicError, IsZeroForEqualExtrinsics) {
  const Eigen::Isometry3d T = exp((Vector6() << 0.1, 0.2, 0.3, 1, 2, 3).finished());
  const ExtrinsicError error = extrinsic_error(T, T, camera());
  EXPECT_NEAR(error.rotation, 0, 1e-9);
  EXPECT_EQ(error.translation, 0);
  EXPECT_NEAR(error.pixels, 0, 1e-6);
}

// A shift t along the camera's x axis moves every projection by f t / z pixels.
TEST(ExtrinsicError, ShiftMovesPixelsByFocalLengthOverDepth) {
  const Eigen::Isometry3d truth = exp((Vector6() << 1.2, -1.2, 1.2, 0.1, 0.2, 0.3).finished());
  Eigen::Isometry3d estimate = truth;
  estimate.translation().x() += 0.1;
  const ExtrinsicError error = extrinsic_error(estimate, truth, camera());
  EXPECT_NEAR(error.translation, 0.1, 1e-12);
  EXPECT_NEAR(error.by_axis[3], 0.1, 1e-12);
  EXPECT_NEAR(error.rotation, 0, 1e-7);
  double sum = 0;  // computed over the same grid: depth is along the ray, z = depth · cos
  int count = 0;
  for (int row = 0; row < 12; ++row) {
    for (int column = 0; column < 12; ++column) {
      const double x = ((column + 0.5) * 1000 / 12 - 0.5 - 499.5) / 800;
      const double y = ((row + 0.5) * 600 / 12 - 0.5 - 299.5) / 800;
      for (const double depth : kComparisonDepths) {
        sum += 800 * 0.1 / (depth / std::sqrt(1 + x * x + y * y));
        ++count;
      }
    }
  }
  EXPECT_NEAR(error.pixels, sum / count, 1e-6);
}

TEST(ExtrinsicError, RotationAboutTheOpticalAxisIsItsThirdComponent) {
  const Eigen::Isometry3d truth = exp((Vector6() << 1.2, -1.2, 1.2, 0.1, 0.2, 0.3).finished());
  Eigen::Isometry3d estimate = truth;
  const double angle = 0.5 * kDegree;
  estimate.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) * truth.linear();
  const ExtrinsicError error = extrinsic_error(estimate, truth, camera());
  EXPECT_NEAR(error.rotation, angle, 1e-12);
  EXPECT_NEAR(error.by_axis[2], angle, 1e-12);
  EXPECT_NEAR(error.by_axis.head<2>().norm(), 0, 1e-12);
  EXPECT_EQ(error.translation, 0);
  EXPECT_GT(error.pixels, 0.5);
}

}  // namespace
}  // namespace infuse::geometry

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/measurement/angles.hpp"
#include "tests/fusion/monitoring/kitti_stream.hpp"
#include "tests/real_data.hpp"

namespace infuse::monitoring {
namespace {

/// All pairs; read once.
const kitti::Stream& stream_of(const std::filesystem::path& folder) {
  static const kitti::Stream read = kitti::read_stream(folder);
  return read;
}

Eigen::Isometry3d turned(const kitti::Stream& stream, double degrees, int axis) {
  return geometry::exp(degrees * kDegree * geometry::Vector6::Unit(axis)) * stream.T_camera_lidar;
}

TEST(RealKittiStream, ThePublishedExtrinsicsHold) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "calibration/kitti");
  const kitti::Stream& stream = stream_of(folder);
  ASSERT_EQ(stream.images.size(), 17U);
  CalibrationMonitor monitor(stream.camera, stream.T_camera_lidar, {});
  const MonitorReport report = kitti::drive(monitor, stream, 4);
  EXPECT_EQ(report.verdict.drift, Drift::kHolds)
      << name_of(report.verdict.axis) << " " << report.verdict.evidence;
  EXPECT_EQ(report.verdict.fault, CameraFault::kNone);
}

TEST(RealKittiStream, ARotationIsDetected) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "calibration/kitti");
  const kitti::Stream& stream = stream_of(folder);
  for (const double degrees : {0.5, 1.0, -2.0}) {
    for (int axis = 0; axis < 3; ++axis) {
      CalibrationMonitor monitor(stream.camera, turned(stream, degrees, axis), {});
      EXPECT_EQ(kitti::drive(monitor, stream, 6).verdict.drift, Drift::kConfirmed)
          << degrees << " " << axis;
    }
  }
}

// The pairs are few places: the stated standard deviation is close to the limit of 0.2 degrees, and
// the noise of the curvature decides on which side it is.
TEST(RealKittiStream, ARotationIsCorrectedOrRefusedAsImprecise) {
  INFUSE_REAL_DATA_OR_SKIP(folder, "calibration/kitti");
  const kitti::Stream& stream = stream_of(folder);
  int usable = 0;
  for (const double degrees : {1.0, -1.0}) {
    for (const int axis : {1, 2}) {
      const Reestimate found = kitti::estimate(stream, turned(stream, degrees, axis));
      if (!found.usable()) {
        EXPECT_THAT(found.reason, testing::HasSubstr("standard deviation of rotation"));
        continue;
      }
      ++usable;
      const geometry::Vector6 error =
          geometry::log(found.T_camera_lidar * stream.T_camera_lidar.inverse());
      EXPECT_LT(error.head<3>().norm(), 0.3 * kDegree) << degrees << " " << axis;
    }
  }
  EXPECT_GE(usable, 1);
}

}  // namespace
}  // namespace infuse::monitoring

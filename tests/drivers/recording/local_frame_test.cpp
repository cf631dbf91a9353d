#include "drivers/recording/local_frame.hpp"
#include "drivers/measurement/angles.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace infuse::recording {
namespace {

TEST(LocalFrame, OriginIsZeroAndUpIsAltitude) {
  const LocalFrame frame(49 * kDegree, 8.4 * kDegree, 115);
  EXPECT_LT(frame.to_local(49 * kDegree, 8.4 * kDegree, 115).norm(), 1e-8);
  const Eigen::Vector3d above = frame.to_local(49 * kDegree, 8.4 * kDegree, 125);
  EXPECT_NEAR(above.x(), 0, 1e-8);
  EXPECT_NEAR(above.y(), 0, 1e-8);
  EXPECT_NEAR(above.z(), 10, 1e-8);
}

// A degree of longitude on the equator is a / 57.29…; a minute of latitude follows the meridian's
// radius of curvature a (1 − e²) / (1 − e² sin²φ)^1.5.
TEST(LocalFrame, FollowsTheRadiiOfCurvatureOfWgs84) {
  const double a = 6378137.0, e2 = 0.00669437999014;
  const double step = 1e-6;  // rad
  const LocalFrame equator(0, 0);
  EXPECT_NEAR(equator.to_local(0, step).x(), a * step, 1e-6);
  for (const double latitude : {0.0, 0.3, 0.855, -1.2}) {
    const double w2 = 1 - e2 * std::pow(std::sin(latitude), 2);
    const LocalFrame frame(latitude, 2.0);
    EXPECT_NEAR(frame.to_local(latitude + step, 2.0).y(), a * (1 - e2) / std::pow(w2, 1.5) * step,
                1e-5);
    EXPECT_NEAR(frame.to_local(latitude, 2.0 + step).x(),
                a / std::sqrt(w2) * std::cos(latitude) * step, 1e-5);
  }
}

TEST(LocalFrame, ThereAndBack) {
  const LocalFrame frame(48.98 * kDegree, 8.39 * kDegree, 110);
  for (const double east : {-1e6, -300.0, 0.0, 12.5, 5000.0, 1e6}) {
    for (const double north : {-1e6, -1.0, 0.0, 700.0}) {
      const Eigen::Vector3d local(east, north, 20);
      const Eigen::Vector3d geodetic = frame.to_geodetic(local);
      const Eigen::Vector3d back = frame.to_local(geodetic.x(), geodetic.y(), geodetic.z());
      EXPECT_LT((back - local).norm(), 1e-6) << east << ' ' << north;
    }
  }
}

}  // namespace
}  // namespace infuse::recording

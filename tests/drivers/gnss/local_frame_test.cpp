#include "drivers/gnss/local_frame.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drivers/measurement/angles.hpp"

namespace infuse::gnss {
namespace {

TEST(LocalFrame, TheOriginIsZeroAndUpIsAltitude) {
  const LocalFrame frame = make_local_frame(49 * kDegree, 8.4 * kDegree, 115);
  EXPECT_LT(to_local(frame, 49 * kDegree, 8.4 * kDegree, 115).norm(), 1e-8);
  const Eigen::Vector3d above = to_local(frame, 49 * kDegree, 8.4 * kDegree, 125);
  EXPECT_NEAR(above.x(), 0, 1e-8);
  EXPECT_NEAR(above.y(), 0, 1e-8);
  EXPECT_NEAR(above.z(), 10, 1e-8);
}

// A radian of longitude on the equator is a; a radian of latitude is the meridian's radius of
// curvature a (1 − e²) / (1 − e² sin²φ)^1.5.
TEST(LocalFrame, FollowsTheRadiiOfCurvatureOfWgs84) {
  const double a = 6378137.0, e2 = 0.00669437999014;
  const double step = 1e-6;  // rad
  const LocalFrame equator = make_local_frame(0, 0);
  EXPECT_NEAR(to_local(equator, 0, step).x(), a * step, 1e-6);
  for (const double latitude : {0.0, 0.3, 0.855, -1.2}) {
    const double w2 = 1 - e2 * std::pow(std::sin(latitude), 2);
    const LocalFrame frame = make_local_frame(latitude, 2.0);
    EXPECT_NEAR(to_local(frame, latitude + step, 2.0).y(), a * (1 - e2) / std::pow(w2, 1.5) * step,
                1e-5);
    EXPECT_NEAR(to_local(frame, latitude, 2.0 + step).x(),
                a / std::sqrt(w2) * std::cos(latitude) * step, 1e-5);
  }
}

TEST(LocalFrame, RoundTrip) {
  const LocalFrame frame = make_local_frame(48.98 * kDegree, 8.39 * kDegree, 110);
  for (const double east : {-1e6, -300.0, 0.0, 12.5, 5000.0, 1e6}) {
    for (const double north : {-1e6, -1.0, 0.0, 700.0}) {
      const Eigen::Vector3d local(east, north, 20);
      const Eigen::Vector3d geodetic = to_geodetic(frame, local);
      const Eigen::Vector3d back = to_local(frame, geodetic.x(), geodetic.y(), geodetic.z());
      EXPECT_LT((back - local).norm(), 1e-6) << east << ' ' << north;
    }
  }
}

}  // namespace
}  // namespace infuse::gnss

#include "drivers/gnss/local_frame.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "drivers/measurement/angles.hpp"

namespace infuse::gnss {
namespace {

constexpr double kHalfStep = 0.5 / 4096;  // m, of the result

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
  EXPECT_NEAR(to_local(equator, 0, step).x(), a * step, kHalfStep + 1e-6);
  for (const double latitude : {0.0, 0.3, 0.855, -1.2}) {
    const double w2 = 1 - e2 * std::pow(std::sin(latitude), 2);
    const LocalFrame frame = make_local_frame(latitude, 2.0);
    EXPECT_NEAR(to_local(frame, latitude + step, 2.0).y(), a * (1 - e2) / std::pow(w2, 1.5) * step,
                kHalfStep + 1e-5);
    EXPECT_NEAR(to_local(frame, latitude, 2.0 + step).x(),
                a / std::sqrt(w2) * std::cos(latitude) * step, kHalfStep + 1e-5);
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

// The last bits of the computation, which differ between processors, are not in the result.
TEST(LocalFrame, PositionsAreWholeSteps) {
  const LocalFrame frame = make_local_frame(48.98 * kDegree, 8.39 * kDegree, 110);
  for (int i = 1; i < 100; ++i) {
    const Eigen::Vector3d local =
        to_local(frame, (48.98 + 1.234e-5 * i) * kDegree, (8.39 - 3.21e-5 * i) * kDegree, 111.1);
    for (const double part : local) EXPECT_EQ(part * 4096, std::round(part * 4096));
  }
}

}  // namespace
}  // namespace infuse::gnss

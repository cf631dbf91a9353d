#include "daemon/mapping/las_file.hpp"
#include "tests/daemon/mapping/cloud_of.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace infuse::daemon {
namespace {

/// Reads a number at the offset that the LAS specification states.
template <class T>
T at(const std::string& bytes, size_t offset) {
  T value{};
  EXPECT_LE(offset + sizeof(T), bytes.size());
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

/// Coordinate of a point as a reader of LAS computes it.
double coordinate(const std::string& las, uint32_t point, size_t axis) {
  const size_t offset = at<uint32_t>(las, 96) + size_t{point} * at<uint16_t>(las, 105);
  return at<int32_t>(las, offset + 4 * axis) * at<double>(las, 131 + 8 * axis) +
         at<double>(las, 155 + 8 * axis);
}

TEST(LasFile, HasPointsAndBoundsInTheFrameOfTheMap) {
  const auto las = format_cloud_las(cloud_of({{1.25F, -70.5F, 2, 1}, {-3, 4, 0.125F, 0.5F}}), {});
  ASSERT_TRUE(las) << las.error().message();
  EXPECT_EQ(las->substr(0, 4), "LASF");
  EXPECT_EQ(at<uint8_t>(*las, 24), 1);
  EXPECT_EQ(at<uint8_t>(*las, 25), 2);
  EXPECT_EQ(at<uint16_t>(*las, 94), 227);
  EXPECT_EQ(at<uint32_t>(*las, 100), 0U);
  EXPECT_EQ(at<uint32_t>(*las, 107), 2U);
  EXPECT_EQ(at<uint32_t>(*las, 111), 2U);
  EXPECT_EQ(las->size(), 227U + 2 * 20);
  const double expected[2][3] = {{1.25, -70.5, 2}, {-3, 4, 0.125}};
  for (uint32_t p = 0; p < 2; ++p) {
    for (size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(coordinate(*las, p, axis), expected[p][axis], 5e-4);
    }
  }
  for (size_t axis = 0; axis < 3; ++axis) {  // maximum, then minimum
    EXPECT_EQ(at<double>(*las, 179 + 16 * axis), std::max(expected[0][axis], expected[1][axis]));
    EXPECT_EQ(at<double>(*las, 187 + 16 * axis), std::min(expected[0][axis], expected[1][axis]));
  }
  EXPECT_EQ(at<uint16_t>(*las, 227 + 12), 65535);
}

/// m, arc of the meridian from the equator on WGS 84, by midpoints.
double meridian_arc(double latitude_deg) {
  constexpr double kAxis = 6378137, kFlattening = 1 / 298.257223563;
  constexpr double kSquareEccentricity = kFlattening * (2 - kFlattening);
  constexpr int kSteps = 10000;
  const double step = latitude_deg * M_PI / 180 / kSteps;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double s = std::sin((i + 0.5) * step);
    sum += step * std::pow(1 - kSquareEccentricity * s * s, -1.5);
  }
  return kAxis * (1 - kSquareEccentricity) * sum;
}

// The central meridian of zone 32 is 9° E, where the easting is 500 km and the scale 0.9996.
TEST(LasFile, IsInUtmWhereTheMapIsGeoreferenced) {
  const auto las = format_cloud_las(cloud_of({{0, 0, 0, 0}, {100, 0, 0, 0}, {0, 100, 5, 0}}),
                                    MapOrigin{.latitude = 49, .longitude = 9, .altitude = 110});
  ASSERT_TRUE(las) << las.error().message();
  EXPECT_EQ(at<uint32_t>(*las, 96), 227U + 54 + 40);
  EXPECT_EQ(std::string(las->c_str() + 227 + 2), "LASF_Projection");
  EXPECT_EQ(at<uint16_t>(*las, 227 + 54 + 2 * 15), 32632);
  EXPECT_NEAR(coordinate(*las, 0, 0), 500000, 1e-3);
  EXPECT_NEAR(coordinate(*las, 0, 1), 0.9996 * meridian_arc(49), 1e-2);
  EXPECT_NEAR(coordinate(*las, 0, 2), 110, 1e-3);
  EXPECT_NEAR(coordinate(*las, 1, 0) - 500000, 99.96, 5e-3);
  EXPECT_NEAR(coordinate(*las, 2, 1) - coordinate(*las, 0, 1), 99.96, 5e-3);
  EXPECT_NEAR(coordinate(*las, 2, 2), 115, 2e-3);
  EXPECT_EQ(at<uint16_t>(*format_cloud_las(cloud_of({{0, 0, 0, 0}}),
                                           MapOrigin{.latitude = -33.9, .longitude = 151.2}),
                         227 + 54 + 2 * 15),
            32756);
}

TEST(LasFile, RefusesWhatItCannotHold) {
  EXPECT_FALSE(format_cloud_las({}, {}));
  EXPECT_FALSE(format_cloud_las(cloud_of({{0, 0, 0, 0}, {1e7F, 0, 0, 0}}), {}));
  EXPECT_FALSE(
      format_cloud_las(cloud_of({{std::numeric_limits<float>::quiet_NaN(), 0, 0, 0}}), {}));
  EXPECT_FALSE(format_cloud_las(cloud_of({{0, 0, 0, 0}}), MapOrigin{.latitude = 85}));
}

}  // namespace
}  // namespace infuse::daemon

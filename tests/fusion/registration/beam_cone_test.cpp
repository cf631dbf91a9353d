#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fusion/registration/lengths.hpp"
#include "fusion/registration/prepared_cloud.hpp"

namespace infuse::registration {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// Share of the points that have a plane.
double planes(const PointCloud& cloud, double min_incidence) {
  PrepareOptions options{.voxel_size = 0.2};
  options.covariance.min_incidence = min_incidence;
  const PreparedCloud prepared = prepare_cloud(cloud.points(), options);
  double count = 0;
  for (size_t i = 0; i < prepared.cloud.size(); ++i) {
    count += prepared.cloud.nx[i] != 0 || prepared.cloud.ny[i] != 0 || prepared.cloud.nz[i] != 0;
  }
  return count / static_cast<double>(prepared.cloud.size());
}

/// Returns of one beam at this elevation from a hedge: near the horizon, at depths that vary.
PointCloud hedge(double elevation) {
  PointCloud out;
  out.resize(900);
  for (size_t i = 0; i < out.size(); ++i) {
    const double azimuth = 0.1 * static_cast<double>(i) * kDegree;
    const double range = 12 + std::sin(60 * azimuth) + 0.5 * std::sin(170 * azimuth);
    out.x[i] = static_cast<float>(range * std::cos(elevation) * std::cos(azimuth));
    out.y[i] = static_cast<float>(range * std::cos(elevation) * std::sin(azimuth));
    out.z[i] = static_cast<float>(range * std::sin(elevation));
  }
  return out;
}

/// Level ground `height` below the lidar, 4 × 4 m, from x on.
PointCloud ground(double height, double x) {
  PointCloud out;
  out.resize(1600);
  for (size_t i = 0; i < out.size(); ++i) {
    out.x[i] = static_cast<float>(x + 0.1 * static_cast<double>(i % 40));
    out.y[i] = static_cast<float>(0.1 * static_cast<double>(i / 40) - 2);
    out.z[i] = static_cast<float>(-height);
  }
  return out;
}

TEST(BeamCone, IsNoSurface) {
  for (const double elevation : {-1.0, 1.0, 5.0}) {
    EXPECT_EQ(planes(hedge(elevation * kDegree), 0), 1) << elevation;
    EXPECT_LT(planes(hedge(elevation * kDegree), kMinIncidence), 0.05) << elevation;
  }
}

TEST(BeamCone, GroundIsASurfaceUntilABeamMeetsItEdgeOn) {
  EXPECT_EQ(planes(ground(1.9, 40), kMinIncidence), 1);  // 2.5° and more
  EXPECT_EQ(planes(ground(1.9, 60), kMinIncidence), 0);  // 1.8° and less
  EXPECT_EQ(planes(ground(1.9, 60), 0), 1);
}

TEST(BeamCone, TheLimitIsTheSineOfAnAngle) {
  CovarianceOptions options;
  options.min_incidence = 1;
  EXPECT_TRUE(options.invalid());
  options.min_incidence = -0.1;
  EXPECT_TRUE(options.invalid());
}

}  // namespace
}  // namespace infuse::registration

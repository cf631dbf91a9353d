#include "fusion/mapping/submap.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>

namespace infuse::mapping {
namespace {

struct Points {
  std::vector<float> x, y, z, reflectivity;
  void add(double px, double py, double pz, double r) {
    x.push_back(static_cast<float>(px));
    y.push_back(static_cast<float>(py));
    z.push_back(static_cast<float>(pz));
    reflectivity.push_back(static_cast<float>(r));
  }
  geometry::PointsView view() const { return {x, y, z}; }
};

// Two sweeps from different poses against means over a std::map of voxels.
TEST(Submap, IsTheMeanOfEveryVoxel) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-6, 6), share(0, 1);
  std::map<std::array<int, 3>, std::array<double, 5>> expected;
  SubmapBuilder builder({.voxel_size = 0.5, .min_range = 2, .max_range = 8});
  for (int sweep = 0; sweep < 2; ++sweep) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = Eigen::Vector3d(1.3 * sweep, 0.2, 0);
    T.linear() = Eigen::AngleAxisd(0.3 * sweep, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    Points points;
    for (int i = 0; i < 4000; ++i)
      points.add(place(random), place(random), place(random) / 4, share(random));
    points.add(std::numeric_limits<double>::quiet_NaN(), 3, 0, 0.5);
    for (size_t i = 0; i < points.x.size(); ++i) {
      const Eigen::Vector3d p(points.x[i], points.y[i], points.z[i]);
      if (!(p.norm() >= 2 && p.norm() <= 8)) continue;
      const Eigen::Vector3d q = T * p;
      auto& cell = expected[{static_cast<int>(std::floor(q.x() / 0.5)),
                             static_cast<int>(std::floor(q.y() / 0.5)),
                             static_cast<int>(std::floor(q.z() / 0.5))}];
      for (int axis = 0; axis < 3; ++axis) cell[static_cast<size_t>(axis)] += q[axis];
      cell[3] += points.reflectivity[i];
      ++cell[4];
    }
    builder.add(points.view(), points.reflectivity, T);
  }
  const Submap cloud = builder.take();
  ASSERT_NEAR(static_cast<double>(cloud.size()), static_cast<double>(expected.size()), 3);
  size_t agree = 0;
  for (const auto& [voxel, cell] : expected) {
    const Eigen::Vector4d mean = Eigen::Vector4d(cell[0], cell[1], cell[2], cell[3]) / cell[4];
    for (size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector4d got(cloud.x[i], cloud.y[i], cloud.z[i], cloud.reflectivity[i]);
      if ((got - mean).cwiseAbs().maxCoeff() < 0.005) {
        ++agree;
        break;
      }
    }
  }
  // A point within single precision of a voxel's face may be in the other one.
  EXPECT_GE(agree + 6, expected.size());
  EXPECT_GT(expected.size(), 500U);
  EXPECT_EQ(builder.take().size(), 0U) << "it begins anew";
}

TEST(Submap, IsQuantised) {
  SubmapBuilder builder({});
  Points points;
  points.add(10.001, -3.3337, 0.1, 0.3);
  builder.add(points.view(), points.reflectivity, Eigen::Isometry3d::Identity());
  const Submap cloud = builder.take();
  ASSERT_EQ(cloud.size(), 1U);
  EXPECT_EQ(cloud.x[0] * 256, std::round(cloud.x[0] * 256));
  EXPECT_NEAR(cloud.y[0], -3.3337, 0.5 * kSubmapStep + 1e-6);
  EXPECT_NEAR(cloud.reflectivity[0], 0.3, 0.5 / 255 + 1e-6);
}

}  // namespace
}  // namespace infuse::mapping

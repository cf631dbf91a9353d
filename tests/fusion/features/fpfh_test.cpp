#include "fusion/features/fpfh.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace infuse::features {
namespace {

using Points = std::vector<Eigen::Vector3f>;

/// A street corner before the sensor: ground, two walls, a pole, all with some noise.
Points street_corner() {
  std::mt19937_64 random(3);
  const auto uniform = [&](double low, double high) {
    return static_cast<float>(low + (high - low) * 0x1p-64 * static_cast<double>(random()));
  };
  Points points;
  for (int i = 0; i < 500; ++i) points.emplace_back(uniform(2, 12), uniform(-6, 6), -1.7F);
  for (int i = 0; i < 300; ++i) points.emplace_back(uniform(2, 12), 6.0F, uniform(-1.7, 4));
  for (int i = 0; i < 300; ++i) points.emplace_back(12.0F, uniform(-6, 6), uniform(-1.7, 4));
  for (int i = 0; i < 60; ++i) points.emplace_back(6.0F, -2.0F, uniform(-1.7, 4));
  for (Eigen::Vector3f& point : points) {
    point += Eigen::Vector3f(uniform(-0.02, 0.02), uniform(-0.02, 0.02), uniform(-0.02, 0.02));
  }
  return points;
}

std::vector<size_t> brute_neighbours(const Points& points, size_t i, double radius) {
  std::vector<size_t> found;
  for (size_t k = 0; k < points.size(); ++k) {
    if ((points[k] - points[i]).norm() < radius) found.push_back(k);
  }
  return found;
}

Eigen::Vector3d brute_normal(const Points& points, const std::vector<size_t>& members) {
  Eigen::MatrixXd centred(3, members.size());
  for (size_t m = 0; m < members.size(); ++m) {
    centred.col(static_cast<Eigen::Index>(m)) = points[members[m]].cast<double>();
  }
  centred.colwise() -= centred.rowwise().mean().eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(centred * centred.transpose());
  return spread.eigenvectors().col(0);
}

/// Histograms of the pairs of a point with its neighbours, as the article states them.
std::array<double, 33> brute_pairs(const Points& points,
                                   const std::vector<Eigen::Vector3d>& normals, size_t i,
                                   const std::vector<size_t>& neighbours) {
  std::array<double, 33> bins{};
  double pairs = 0;
  for (const size_t k : neighbours) {
    if (k == i) continue;
    Eigen::Vector3d line = (points[k] - points[i]).cast<double>().normalized();
    Eigen::Vector3d u = normals[i], other = normals[k];
    if (std::acos(std::abs(u.dot(line))) > std::acos(std::abs(other.dot(line)))) {
      std::swap(u, other);
      line = -line;
    }
    const Eigen::Vector3d v = line.cross(u).normalized(), w = u.cross(v);
    const double alpha = v.dot(other), phi = u.dot(line);
    const double theta = std::atan2(w.dot(other), u.dot(other));
    const auto bin = [](double fraction) {
      return std::min<size_t>(10, static_cast<size_t>(11 * std::max(0.0, fraction)));
    };
    bins[bin((alpha + 1) / 2)] += 1;
    bins[11 + bin((phi + 1) / 2)] += 1;
    bins[22 + bin(theta / (2 * std::numbers::pi) + 0.5)] += 1;
    pairs += 1;
  }
  for (double& count : bins) count *= 100 / pairs;
  return bins;
}

double difference(const Fpfh& a, const Fpfh& b) {
  double sum = 0;
  for (size_t bin = 0; bin < a.size(); ++bin) sum += std::abs(a[bin] - b[bin]);
  return sum;
}

TEST(Fpfh, MatchesABruteForceComputation) {
  const Points points = street_corner();
  FpfhOptions options;
  options.max_neighbours = 2000;
  const FpfhCloud cloud = compute_fpfh(points, options);
  std::vector<Eigen::Vector3d> normals;
  for (size_t i = 0; i < points.size(); ++i) {
    normals.push_back(brute_normal(points, brute_neighbours(points, i, options.normal_radius)));
    if (normals[i].dot(points[i].cast<double>()) > 0) normals[i] *= -1;
    EXPECT_LT(1 - std::abs(normals[i].dot(cloud.normals[i].cast<double>())), 1e-4) << i;
    // Points of one line or plane through the sensor face neither way for certain.
    normals[i] = cloud.normals[i].cast<double>();
  }
  for (size_t i = 0; i < points.size(); i += 37) {
    ASSERT_EQ(cloud.has_feature[i], 1) << i;
    const auto neighbours = brute_neighbours(points, i, options.feature_radius);
    std::array<double, 33> expected{};
    for (const size_t k : neighbours) {
      if (k == i) continue;
      const auto theirs =
          brute_pairs(points, normals, k, brute_neighbours(points, k, options.feature_radius));
      const double distance = (points[k] - points[i]).norm();
      for (size_t bin = 0; bin < 33; ++bin) expected[bin] += theirs[bin] / distance;
    }
    const auto own = brute_pairs(points, normals, i, neighbours);
    const auto others = static_cast<double>(neighbours.size() - 1);
    for (size_t bin = 0; bin < 33; ++bin) expected[bin] = own[bin] + expected[bin] / others;
    for (size_t part = 0; part < 3; ++part) {
      double sum = 0;
      for (size_t bin = 11 * part; bin < 11 * part + 11; ++bin) sum += expected[bin];
      for (size_t bin = 11 * part; bin < 11 * part + 11; ++bin) {
        // A pair on the border of two bins may fall into either.
        EXPECT_NEAR(cloud.features[i][bin], 100 * expected[bin] / sum, 1) << i << " " << bin;
      }
    }
  }
}

TEST(Fpfh, IsTheSameAfterARotationAboutTheSensor) {
  const Points points = street_corner();
  Points turned;
  const Eigen::Matrix3f R =
      Eigen::AngleAxisf(2.5F, Eigen::Vector3f(0.2F, -0.3F, 0.9F).normalized()).matrix();
  for (const Eigen::Vector3f& point : points) turned.emplace_back(R * point);
  const FpfhCloud a = compute_fpfh(points), b = compute_fpfh(turned);
  double sum = 0, count = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(a.has_feature[i], b.has_feature[i]);
    if (a.has_feature[i] == 0) continue;
    sum += difference(a.features[i], b.features[i]);
    count += 1;
  }
  EXPECT_LT(sum / count, 3);  // of a total of 300: pairs on the border of two bins
}

TEST(Fpfh, TellsGroundWallAndPoleApart) {
  const Points points = street_corner();
  const FpfhCloud cloud = compute_fpfh(points);
  // Inside of the ground, another place of it, and the pole.
  const auto nearest = [&](const Eigen::Vector3f& place) {
    return static_cast<size_t>(std::min_element(points.begin(), points.end(),
                                                [&](const auto& a, const auto& b) {
                                                  return (a - place).norm() < (b - place).norm();
                                                }) -
                               points.begin());
  };
  const size_t ground = nearest({9, 2, -1.7F}), more_ground = nearest({4.5F, 2, -1.7F});
  const size_t pole = nearest({6, -2, 2});
  EXPECT_GT(difference(cloud.features[ground], cloud.features[pole]),
            2 * difference(cloud.features[ground], cloud.features[more_ground]));
}

TEST(Fpfh, PointsThatAreNoMeasurementsHaveNone) {
  EXPECT_TRUE(compute_fpfh(Points()).features.empty());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  Points points = street_corner();
  const FpfhCloud clean = compute_fpfh(points);
  const size_t real = points.size();
  points.insert(points.end(), {{nan, 0, 0}, {0, nan, nan}, {infinity, 0, 0}, {1e30F, 0, 0}});
  points.emplace_back(500.0F, 500.0F, 0.0F);  // alone
  const FpfhCloud cloud = compute_fpfh(points);
  for (size_t i = 0; i < real; ++i) EXPECT_EQ(cloud.features[i], clean.features[i]);
  for (size_t i = real; i < points.size(); ++i) EXPECT_EQ(cloud.has_feature[i], 0) << i;
  const FpfhCloud same = compute_fpfh(Points(1000, {1, 2, 3}));  // one place, a thousand times
  for (const Fpfh& feature : same.features) {
    for (const float count : feature) EXPECT_TRUE(std::isfinite(count));
  }
}

TEST(Fpfh, StatesWhatIsWrongWithTheOptions) {
  EXPECT_FALSE(FpfhOptions().invalid());
  EXPECT_TRUE(FpfhOptions{.normal_radius = 0}.invalid());
  EXPECT_TRUE(FpfhOptions{.feature_radius = std::nan("")}.invalid());
  EXPECT_TRUE(FpfhOptions{.min_neighbours = 2}.invalid());
  EXPECT_TRUE(FpfhOptions{.max_neighbours = 4}.invalid());
}

}  // namespace
}  // namespace infuse::features

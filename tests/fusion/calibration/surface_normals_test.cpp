#include "fusion/calibration/surface_normals.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

namespace infuse::calibration {
namespace {

void add(Sweep& sweep, const Eigen::Vector3d& p, uint16_t ring = 0, uint16_t column = 0) {
  const size_t at = sweep.size();
  sweep.resize(at + 1);
  sweep.x[at] = static_cast<float>(p.x());
  sweep.y[at] = static_cast<float>(p.y());
  sweep.z[at] = static_cast<float>(p.z());
  sweep.range[at] = static_cast<float>(p.norm());
  sweep.ring[at] = ring;
  sweep.column[at] = column;
}

double draw(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

Eigen::Vector3d normal_of(const std::array<std::vector<float>, 3>& normals, size_t i) {
  return {normals[0][i], normals[1][i], normals[2][i]};
}

TEST(SurfaceNormals, OfRoadAndWallFaceTheSensor) {
  Sweep sweep;
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) {
    add(sweep, {draw(random, 3, 8), draw(random, -3, 3), -1.8});  // road
    add(sweep, {draw(random, -8, -3), 40, draw(random, 0, 5)});   // a wall to the left
  }
  const auto normals = surface_normals(sweep, {.max_normals = 0});
  for (size_t i = 0; i < sweep.size(); i += 2) {
    EXPECT_LT((normal_of(normals, i) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-3);
    EXPECT_LT((normal_of(normals, i + 1) - Eigen::Vector3d(0, -1, 0)).norm(), 1e-3);
  }
}

TEST(SurfaceNormals, MatchABruteForceSearch) {
  Sweep sweep;
  std::mt19937_64 random(2);
  for (int i = 0; i < 300; ++i) {
    add(sweep, {draw(random, 4, 7), draw(random, -2, 2), draw(random, -1, 1)});
  }
  const auto normals =
      surface_normals(sweep, {.neighbours = 12, .max_neighbour_distance = 10, .max_normals = 0});
  for (size_t i = 0; i < sweep.size(); i += 7) {
    const Eigen::Vector3d here(sweep.x[i], sweep.y[i], sweep.z[i]);
    std::vector<Eigen::Vector3d> all;
    for (size_t j = 0; j < sweep.size(); ++j) all.push_back({sweep.x[j], sweep.y[j], sweep.z[j]});
    std::sort(all.begin(), all.end(), [&](const auto& a, const auto& b) {
      return (a - here).squaredNorm() < (b - here).squaredNorm();
    });
    Eigen::Matrix<double, 3, 12> near;
    for (int k = 0; k < 12; ++k) near.col(k) = all[static_cast<size_t>(k)];
    const Eigen::Matrix<double, 3, 12> centred = near.colwise() - near.rowwise().mean();
    const Eigen::JacobiSVD<Eigen::Matrix<double, 3, 12>> svd(centred, Eigen::ComputeFullU);
    const Eigen::Vector3d expected = svd.matrixU().col(2);
    EXPECT_NEAR(std::abs(normal_of(normals, i).dot(expected)), 1, 1e-3) << i;
    EXPECT_LE(normal_of(normals, i).dot(here), 0) << i;
  }
}

TEST(SurfaceNormals, NoneWhereReturnsAreFewOrFar) {
  Sweep sweep;
  std::mt19937_64 random(3);
  for (int i = 0; i < 200; ++i) add(sweep, {draw(random, 3, 4), draw(random, 0, 1), -1.8});
  add(sweep, {60, 0, 2});
  const auto normals =
      surface_normals(sweep, {.neighbours = 50, .max_neighbour_distance = 2, .max_normals = 0});
  EXPECT_TRUE(std::isnan(normals[0].back()));
  EXPECT_FALSE(std::isnan(normals[0].front()));
  const auto few = surface_normals(sweep, {.neighbours = 500});
  for (const float x : few[0]) EXPECT_TRUE(std::isnan(x));
}

TEST(SurfaceNormals, AreSpreadEvenlyIfLimitedInNumber) {
  Sweep sweep;
  std::mt19937_64 random(4);
  for (int i = 0; i < 1000; ++i) add(sweep, {draw(random, 3, 5), draw(random, -1, 1), -1.8});
  const auto normals = surface_normals(sweep, {.neighbours = 20, .max_normals = 250});
  for (size_t i = 0; i < sweep.size(); ++i) EXPECT_EQ(std::isnan(normals[2][i]), i % 4 != 0) << i;
}

TEST(SurfaceNormals, SayWhatIsWrongWithTheirOptions) {
  EXPECT_FALSE(NormalOptions{}.invalid());
  EXPECT_TRUE((NormalOptions{.neighbours = 2}.invalid()));
  EXPECT_TRUE((NormalOptions{.max_neighbour_distance = 0}.invalid()));
}

}  // namespace
}  // namespace infuse::calibration

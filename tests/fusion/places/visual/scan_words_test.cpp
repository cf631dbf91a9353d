#include "fusion/places/visual/scan_words.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace infuse::places {
namespace {

TEST(WordInformation, IsTheEntropyOfWordsThatAgree) {
  std::vector<std::pair<int, int>> same, independent;
  for (int i = 0; i < 4000; ++i) {
    same.emplace_back(i % 8, i % 8);
    independent.emplace_back(i % 8, (i / 8) % 5);
  }
  EXPECT_NEAR(word_information(same, same.size()), std::log(8), 1e-3);
  EXPECT_NEAR(word_information(independent, 2 * independent.size()), 0, 1e-3);
  EXPECT_EQ(word_information({{1, 1}, {2, 2}}, 2), 0);  // too few
}

TEST(MapScan, HasMostInformationAtTheTruePose) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> level(-25, 25);
  ScanWords words, moved;
  constexpr double kX = 1.5, kY = -0.5, kYaw = 0.4;
  const Eigen::AngleAxisf back(static_cast<float>(-kYaw), Eigen::Vector3f::UnitZ());
  for (int i = 0; i < 3000; ++i) {
    ScanWords::Voxel v;
    v.centre = {level(random), level(random), 0.5F};
    v.reflectivity = static_cast<int16_t>(random() % 8);
    v.grey = static_cast<int16_t>(random() % 8);
    words.voxels.push_back(v);
    v.centre = back * (v.centre - Eigen::Vector3f(kX, kY, 0));
    moved.voxels.push_back(v);
  }
  const MapScan map(words);
  const auto at = [&](double x, double y, double yaw) {
    return map.information(moved, x, y, yaw).total(true);
  };
  const double there = at(kX, kY, kYaw);
  EXPECT_GT(there, 1);
  EXPECT_GT(there, at(kX + 2, kY, kYaw) + 0.5);
  EXPECT_GT(there, at(kX, kY, kYaw + 0.3) + 0.5);
}

}  // namespace
}  // namespace infuse::places

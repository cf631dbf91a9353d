#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/study/places/bag_of_words.hpp"
#include "tests/study/places/precision_recall.hpp"
#include "tests/study/places/scan_context.hpp"
#include "tests/study/places/scan_words.hpp"

namespace infuse::study {
namespace {

TEST(PrecisionRecall, IsThatOfTheDefinition) {
  // By falling score: right, right, wrong, right, wrong (off the map).
  const PrecisionRecall curve = precision_recall({{0.9, true, true},
                                                  {0.5, true, true},
                                                  {0.8, true, true},
                                                  {0.7, false, true},
                                                  {0.4, false, false}});
  EXPECT_DOUBLE_EQ(curve.recall_at_full, 0.5);
  EXPECT_DOUBLE_EQ(curve.recall, 0.75);
  EXPECT_DOUBLE_EQ(curve.precision, 0.6);
  EXPECT_DOUBLE_EQ(curve.area, 0.25 + 0.25 + 0.25 * (2.0 / 3 + 0.75) / 2);
}

TEST(PrecisionRecall, DoesNotSplitTies) {
  const PrecisionRecall curve = precision_recall({{0.5, true, true}, {0.5, false, true}});
  EXPECT_EQ(curve.recall_at_full, 0);
  EXPECT_EQ(curve.recall, 0.5);
}

TEST(BagOfWords, IgnoresWhatAllPlacesHave) {
  const BagOfWords bag({{0, 0, 0, 1}, {0, 0, 0, 2}, {0, 3, 3, 3}}, 5);
  const Eigen::VectorXd same = bag.similarities({0, 1});
  EXPECT_NEAR(same[0], 1, 1e-12);
  EXPECT_NEAR(same[1], 0, 1e-12);
  EXPECT_EQ(bag.similarities({4}).norm(), 0);
  EXPECT_EQ(bag.similarities({}).norm(), 0);
}

TEST(ScanContext, IsOneOfATurnedPlace) {
  std::mt19937 random(3);
  places::PlaceDescriptor place, turned, other;
  for (int sector = 0; sector < places::kSectors; ++sector) {
    for (int ring = 0; ring < places::kRings; ++ring) {
      place.heights(ring, sector) = static_cast<float>(random() % 12);
      other.heights(ring, sector) = static_cast<float>(random() % 12);
    }
  }
  for (int sector = 0; sector < places::kSectors; ++sector)
    turned.heights.col((sector + 17) % places::kSectors) = place.heights.col(sector);
  EXPECT_NEAR(scan_context_similarity(place, turned), 1, 1e-6);
  EXPECT_LT(scan_context_similarity(place, other), 0.9);
  EXPECT_EQ(scan_context_similarity(place, {}), 0);
}

TEST(WordInformation, IsTheEntropyOfWordsThatAgree) {
  std::vector<std::pair<int, int>> same, independent;
  for (int i = 0; i < 4000; ++i) {
    same.emplace_back(i % 8, i % 8);
    independent.emplace_back(i % 8, (i / 8) % 5);
  }
  EXPECT_NEAR(word_information(same), std::log(8), 1e-3);
  EXPECT_NEAR(word_information(independent), 0, 1e-3);
  EXPECT_EQ(word_information({{1, 1}, {2, 2}}), 0);  // too few
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
    return map.information(moved, x, y,
                           yaw)[static_cast<size_t>(FeatureSet::kReflectivityGreyNormal)];
  };
  const double there = at(kX, kY, kYaw);
  EXPECT_GT(there, 1);
  EXPECT_GT(there, at(kX + 2, kY, kYaw) + 0.5);
  EXPECT_GT(there, at(kX, kY, kYaw + 0.3) + 0.5);
}

}  // namespace
}  // namespace infuse::study

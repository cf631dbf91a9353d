#include <gtest/gtest.h>

#include <random>

#include "tests/study/places/precision_recall.hpp"
#include "tests/study/places/scan_context.hpp"

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

}  // namespace
}  // namespace infuse::study

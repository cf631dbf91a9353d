#include "fusion/places/visual/sequence_information.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "fusion/places/match_evidence.hpp"

namespace infuse::places {
namespace {

constexpr size_t kCells = 60, kPlaces = 50;

/// Words of cells at random places: of each its own.
CellWords random_words(unsigned seed, size_t count) {
  std::mt19937 random(seed);
  CellWords out(count);
  for (auto& image : out) {
    for (size_t cell = 0; cell < kCells; ++cell)
      image.push_back(static_cast<int32_t>(random() % 4));
  }
  return out;
}

/// Another season: every word has become another one, and half of the cells are anything.
CellWords in_another_season(const CellWords& places, size_t begin, size_t count) {
  std::mt19937 random(9);
  CellWords out(places.begin() + static_cast<std::ptrdiff_t>(begin),
                places.begin() + static_cast<std::ptrdiff_t>(begin + count));
  for (auto& image : out) {
    for (int32_t& word : image)
      word = random() % 2 == 0 ? (word * 3 + 1) % 4 : static_cast<int32_t>(random() % 4);
  }
  return out;
}

class SequenceInformation : public testing::TestWithParam<int> {};

TEST_P(SequenceInformation, FindsPlacesWhoseWordsHaveChanged) {
  const CellWords places = random_words(1, kPlaces);
  const CellWords queries = in_another_season(places, 15, 30);
  const SequenceInformationOptions options{.length = 7, .memory = GetParam()};
  const auto matches = match_by_information(queries, places, options);
  ASSERT_EQ(matches.size(), queries.size());
  for (size_t i = 0; i < matches.size(); ++i) {
    EXPECT_EQ(matches[i].place, i + 15);
    EXPECT_GT(matches[i].margin, 0);
  }
  const CellWords reversed(queries.rbegin(), queries.rend());
  const MatchEvidence evidence(match_by_information(reversed, places, options), options.length);
  EXPECT_LT(evidence.chances(matches)[15], 0.02);
  const auto elsewhere = match_by_information(random_words(5, 30), places, options);
  for (const double chance : evidence.chances(elsewhere)) EXPECT_GT(chance, 0.02);
}
INSTANTIATE_TEST_SUITE_P(Memories, SequenceInformation, testing::Values(0, 1));

TEST(SequenceInformationOfFew, IsThatOfAllThatThereAre) {
  const CellWords places = random_words(1, 5);
  const auto matches = match_by_information(places, places, {.length = 21, .memory = 0});
  ASSERT_EQ(matches.size(), 5U);
  for (size_t i = 0; i < 5; ++i) EXPECT_EQ(matches[i].place, i);
  EXPECT_TRUE(match_by_information({}, places).empty());
}

TEST(CellWords, AreTheClustersOfCells) {
  std::vector<ImageDescriptor> images(3);
  for (size_t k = 0; k < images.size(); ++k) {
    images[k] = {.rows = 1, .columns = 4, .orientations = 2, .values = {}};
    for (size_t cell = 0; cell < 4; ++cell) {
      const float side = (cell + k) % 2 == 0 ? 1.0F : -1.0F;
      images[k].values.push_back(side);
      images[k].values.push_back(-side);
    }
  }
  const CellWords words = cell_words(images, learn_cell_words(images, 2));
  for (size_t k = 0; k < 3; ++k) {
    for (size_t cell = 0; cell < 4; ++cell)
      EXPECT_EQ(words[k][cell] == words[0][0], (cell + k) % 2 == 0);
  }
}

}  // namespace
}  // namespace infuse::places

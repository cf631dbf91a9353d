#include "fusion/places/sequence_match.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "fusion/places/match_evidence.hpp"

namespace infuse::places {
namespace {

SimilarityTable random_table(size_t queries, size_t places, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> value(0, 1);
  SimilarityTable table{queries, places, {}};
  table.values.resize(queries * places);
  for (float& v : table.values) v = value(random);
  return table;
}

/// The definition: each column and row standardised, every path tried.
double best_path_score(const SimilarityTable& raw, size_t middle, size_t place,
                       const SequenceMatchOptions& options) {
  std::vector<std::vector<double>> z(raw.queries, std::vector<double>(raw.places));
  for (size_t i = 0; i < raw.queries; ++i) {
    for (size_t j = 0; j < raw.places; ++j) z[i][j] = static_cast<double>(raw.at(i, j));
  }
  const auto standardise = [](std::vector<double*> values) {
    const auto n = static_cast<double>(values.size());
    double mean = 0, variance = 0;
    for (const double* v : values) mean += *v / n;
    for (const double* v : values) variance += (*v - mean) * (*v - mean) / n;
    for (double* v : values) *v = (*v - mean) / std::sqrt(variance);
  };
  for (auto& row : z) {
    std::vector<double*> values;
    for (double& v : row) values.push_back(&v);
    standardise(values);
  }
  for (size_t j = 0; j < raw.places; ++j) {
    std::vector<double*> values;
    for (auto& row : z) values.push_back(&row[j]);
    standardise(values);
  }
  double best = -1e9;
  std::function<void(size_t, size_t, double)> go = [&](size_t row, size_t at, double sum) {
    if (row == middle && at != place) return;
    sum += z[row][at];
    if (row + 1 == raw.queries) {
      best = std::max(best, sum / static_cast<double>(raw.queries));
      return;
    }
    for (size_t step = 0; step <= options.max_step && at + step < raw.places; ++step) {
      go(row + 1, at + step, sum - (step == 1 ? 0 : options.step_penalty));
    }
  };
  for (size_t start = 0; start < raw.places; ++start) go(0, start, 0);
  return best;
}

TEST(SequenceMatch, IsTheBestOfAllPaths) {
  const SequenceMatchOptions options{.length = 5, .step_penalty = 0.2, .neighbourhood = 1};
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const SimilarityTable table = random_table(5, 9, seed);
    const auto matches = match_sequences(table, options);
    for (size_t middle = 0; middle < 5; ++middle) {
      double best = -1e9;
      size_t place = 0;
      std::vector<double> scores;
      for (size_t j = 0; j < 9; ++j) {
        scores.push_back(best_path_score(table, middle, j, options));
        if (scores[j] > best) best = scores[j], place = j;
      }
      EXPECT_EQ(matches[middle].place, place);
      EXPECT_NEAR(matches[middle].score, best, 1e-5);
      double other = -1e9;
      for (size_t j = 0; j < 9; ++j) {
        if (j + 1 < place || j > place + 1) other = std::max(other, scores[j]);
      }
      EXPECT_NEAR(matches[middle].margin, best - other, 1e-5);
    }
  }
}

// A weak true diagonal that a query passes at changing speed.
TEST(SequenceMatch, FindsWhatSingleImagesDoNotAtChangingSpeed) {
  constexpr size_t kQueries = 150, kPlaces = 400;
  SimilarityTable table = random_table(kQueries, kPlaces, 7);
  std::vector<size_t> truth(kQueries);
  for (size_t i = 0, place = 20; i < kQueries; ++i) {
    truth[i] = place;
    table.at(i, place) += 2;
    place += i < 50 ? 1 : i < 100 ? 2 : i % 2;
  }
  const auto right = [&](size_t length) {
    const auto matches = match_sequences(table, {.length = length});
    size_t count = 0;
    for (size_t i = 0; i < kQueries; ++i) {
      count += matches[i].place + 2 >= truth[i] && matches[i].place <= truth[i] + 2 ? 1U : 0U;
    }
    return static_cast<double>(count) / kQueries;
  };
  EXPECT_LT(right(1), 0.5);
  EXPECT_GT(right(21), 0.97);
}

TEST(SequenceMatch, NothingAndLittleAreAnswered) {
  EXPECT_TRUE(match_sequences({}).empty());
  EXPECT_EQ(match_sequences({3, 0, {}}).size(), 3U);
  const auto one = match_sequences({1, 1, {0.5F}});
  EXPECT_EQ(one.at(0).place, 0U);
  EXPECT_EQ(one.at(0).margin, 0);
  EXPECT_TRUE((SequenceMatchOptions{.length = 0}.invalid()));
}

/// Queries that pass the places from `first` on, one by one, seen with noise.
SimilarityTable passing_table(size_t queries, size_t places, size_t first, unsigned seed) {
  SimilarityTable table = random_table(queries, places, seed);
  for (size_t i = 0; i < queries && first + i < places; ++i) table.at(i, first + i) += 2.5F;
  return table;
}

TEST(MatchEvidence, FindsWhatIsThere) {
  const SimilarityTable table = passing_table(80, 200, 60, 4);
  size_t found = 0;
  const auto matches = match_sequences(table, {});
  const auto chances = MatchEvidence(table, {}).chances(matches);
  for (size_t i = 0; i < matches.size(); ++i) {
    if (chances[i] > 0.02) continue;
    ++found;
    EXPECT_NEAR(static_cast<double>(matches[i].place), 60.0 + static_cast<double>(i), 5);
  }
  EXPECT_GT(found, 55U);
}

/// As of streets that look alike for a while: noise, smooth along both drives.
SimilarityTable smooth_table(size_t queries, size_t places, unsigned seed) {
  constexpr size_t kReach = 4;
  const SimilarityTable raw = random_table(queries + kReach, places + kReach, seed);
  SimilarityTable table{queries, places, {}};
  for (size_t i = 0; i < queries; ++i) {
    for (size_t j = 0; j < places; ++j) {
      float sum = 0;
      for (size_t k = 0; k <= kReach; ++k) {
        for (size_t l = 0; l <= kReach; ++l) sum += raw.at(i + k, j + l);
      }
      table.values.push_back(sum);
    }
  }
  return table;
}

// Of queries that are nowhere no more than the stated share is found, over many drives, whose
// sequences overlap: of as few queries as are allowed, and of more.
TEST(MatchEvidence, IsRareByChance) {
  for (const size_t length : {9U, 21U}) {
    for (const size_t queries : {3 * length, size_t{80}}) {
      size_t found = 0, all = 0;
      for (unsigned seed = 1; seed <= 240; ++seed) {
        const SimilarityTable table = smooth_table(queries, 60, 100 + seed);
        const auto matches = match_sequences(table, {.length = length});
        for (const double chance : MatchEvidence(table, {.length = length}).chances(matches)) {
          ++all;
          found += chance <= 0.02 ? 1U : 0U;
        }
      }
      EXPECT_EQ(all, 240 * queries);
      EXPECT_LT(static_cast<double>(found), 0.02 * static_cast<double>(all));
    }
  }
}

TEST(MatchEvidence, KnowsNothingOfAShortDrive) {
  const SimilarityTable table = passing_table(14, 50, 10, 2);
  const auto matches = match_sequences(table, {.length = 5});
  for (const double chance : MatchEvidence(table, {.length = 5}).chances(matches))
    EXPECT_EQ(chance, 1);
}

std::vector<SequenceMatch> with_margins(const std::vector<double>& margins) {
  std::vector<SequenceMatch> out(margins.size());
  for (size_t i = 0; i < margins.size(); ++i) out[i].margin = margins[i];
  return out;
}

// The wide distribution of the right margins exceeds that by chance on both sides of it.
TEST(MatchEvidence, IsNoneInAMarginBelowChance) {
  std::vector<double> by_chance, margins;
  for (size_t i = 0; i < 67; ++i) by_chance.push_back(0.25 + 0.12 * static_cast<double>(i) / 66);
  for (size_t i = 0; i < 56; ++i) margins.push_back(0.6 + 1.6 * static_cast<double>(i) / 55);
  margins.push_back(0.05);
  margins.insert(margins.end(), 10, 0.32);
  const auto chances = MatchEvidence(with_margins(by_chance), 9).chances(with_margins(margins));
  for (size_t i = 0; i < 56; ++i) EXPECT_LT(chances[i], 0.02);
  for (size_t i = 56; i < chances.size(); ++i) EXPECT_GT(chances[i], 0.9);
}

// Half of the queries are elsewhere: what is stated of all is as often so.
TEST(MatchEvidence, StatesAsManyAsThereAre) {
  const SimilarityTable table = passing_table(160, 80, 0, 6);
  const auto matches = match_sequences(table, {.length = 9});
  double by_chance = 0;
  for (const double chance : MatchEvidence(table, {.length = 9}).chances(matches))
    by_chance += chance / static_cast<double>(matches.size());
  EXPECT_NEAR(by_chance, 0.5, 0.1);
}

TEST(MatchEvidence, HasTheDensityOfAGumbelDistribution) {
  // Mean 0, standard deviation 1: scale sqrt(6) / pi, location -gamma times it.
  const MatchEvidence::Chance chance{0, 1};
  const double scale = std::sqrt(6.0) / M_PI, location = -0.5772156649 * scale;
  for (const double x : {-1.0, 0.0, 1.0, 3.0}) {
    const double z = (x - location) / scale;
    EXPECT_NEAR(chance.density(x), std::exp(-z - std::exp(-z)) / scale, 1e-9);
  }
}

}  // namespace
}  // namespace infuse::places

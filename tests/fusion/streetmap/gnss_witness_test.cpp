#include "fusion/streetmap/gnss_witness.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace infuse::streetmap {
namespace {

using Verdict = GnssWitness::Verdict;

/// Fixes at 5 Hz that are off by `offset`, with noise of 1 m; the pose on the map is the origin.
void add_fixes(GnssWitness& witness, double seconds, const Eigen::Vector2d& offset, double hdop,
               uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise;
  for (int i = 0; i < static_cast<int>(seconds * 5); ++i) {
    witness.advance(0.2);
    witness.add({offset + Eigen::Vector2d(noise(random), noise(random)), {}, hdop}, {0, 0}, 0.3);
  }
}

TEST(GnssWitness, AnOffsetOfMetresIsAStateAndNoContradiction) {
  GnssWitness witness({});
  EXPECT_FALSE(witness.offset());
  add_fixes(witness, 60, {4, -3}, 1);
  EXPECT_EQ(witness.verdict(), Verdict::kNone);
  ASSERT_TRUE(witness.offset());
  EXPECT_NEAR((*witness.offset() - Eigen::Vector2d(4, -3)).norm(), 0, 1);
  EXPECT_LT(witness.offset_sigma(), 1.5);
}

TEST(GnssWitness, AContradictionThatLastsIsADoubtThenALoss) {
  GnssWitness witness({});
  add_fixes(witness, 20, {1, 1}, 1);
  add_fixes(witness, 8, {20, 0}, 1);
  EXPECT_EQ(witness.verdict(), Verdict::kDoubt);
  add_fixes(witness, 15, {20, 0}, 1);
  EXPECT_EQ(witness.verdict(), Verdict::kLost);
  const auto place = witness.place({0, 0});
  ASSERT_TRUE(place);
  EXPECT_NEAR((place->position - Eigen::Vector2d(20, 0)).norm(), 0, 2);
  witness.advance(10);
  EXPECT_FALSE(witness.place({0, 0})) << "the fixes are old";
  EXPECT_EQ(witness.verdict(), Verdict::kLost) << "silence is no agreement";
}

TEST(GnssWitness, ADilutedFixProvesLittle) {
  GnssWitness witness({});
  add_fixes(witness, 60, {20, 0}, 15);
  EXPECT_EQ(witness.verdict(), Verdict::kNone);
  EXPECT_GT(witness.log_likelihood({0, 0}), -0.01);
}

// A receiver that is wrong altogether is anywhere in the area: a factor of ln(area) at most.
TEST(GnssWitness, OfPlacesInALargeAreaAFixRulesOutTheMore) {
  GnssWitness witness({});
  witness.add({{0, 0}, {}, 1});
  const auto odds = [&](double area) {
    return witness.log_likelihood_in(area, {3, 0}, true) -
           witness.log_likelihood_in(area, {500, 0}, true);
  };
  EXPECT_NEAR(odds(4e6) - odds(4e4), std::log(100), 0.01);
  EXPECT_GT(odds(4e6), 12);
  EXPECT_LT(odds(4e6), 17);
  witness.advance(0.5);
  witness.add({{0, 0}, {}, 1});
  EXPECT_GT(witness.log_likelihood_in(4e6, {500, 0}, false), -0.5) << "its error lasts";
  witness.advance(60);
  witness.add({{0, 0}, {}, 15});
  EXPECT_GT(witness.log_likelihood_in(4e6, {60, 0}, false), -2) << "few satellites";
  EXPECT_LT(witness.log_likelihood_in(4e6, {500, 0}, false), -7);
}

TEST(GnssWitness, ThePlaceIsTheFixWhereTheOffsetDoesNotFollow) {
  GnssWitness witness({});
  add_fixes(witness, 5, {3000, 0}, 1);
  ASSERT_TRUE(witness.place({0, 0}));
  EXPECT_NEAR((witness.place({0, 0})->position - Eigen::Vector2d(3000, 0)).norm(), 0, 8);
  GnssWitness near({});
  EXPECT_EQ(near.log_odds({12, 0}, {0, 0}), 0) << "no fix";
  add_fixes(near, 20, {12, 0}, 1);
  EXPECT_GT(near.log_odds({12, 0}, {0, 0}), 1);
  EXPECT_LT(near.log_odds({-12, 0}, {0, 0}), -1);
}

TEST(GnssWitness, SingleOutliersDoNotContradict) {
  GnssWitness witness({});
  for (uint64_t i = 0; i < 20; ++i) {
    add_fixes(witness, 3, {1, 0}, 1, i);
    witness.advance(0.2);
    witness.add({{300, -200}, {}, 1}, {0, 0}, 0.3);
    EXPECT_EQ(witness.verdict(), Verdict::kNone) << i;
  }
}

TEST(GnssWitness, ARefutedReceiverMustBeFurtherOffUntilItAgrees) {
  GnssWitness witness({});
  add_fixes(witness, 30, {19, 0}, 1);
  EXPECT_EQ(witness.verdict(), Verdict::kLost);
  witness.restart(true);
  add_fixes(witness, 30, {19, 0}, 1);
  EXPECT_EQ(witness.verdict(), Verdict::kNone);
  add_fixes(witness, 30, {40, 0}, 1);
  EXPECT_EQ(witness.verdict(), Verdict::kLost);
}

TEST(GnssOptions, ReportsInvalidValues) {
  EXPECT_FALSE(GnssOptions().invalid());
  EXPECT_TRUE(GnssOptions{.map_sigma = 0}.invalid());
  EXPECT_TRUE(GnssOptions{.lost_seconds = 1}.invalid());
}

}  // namespace
}  // namespace infuse::streetmap

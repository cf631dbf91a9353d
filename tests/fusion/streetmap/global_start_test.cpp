#include "fusion/streetmap/global_start.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/fusion/streetmap/town.hpp"

namespace infuse::streetmap {
namespace {

constexpr double kRight = -std::numbers::pi / 2, kLeft = std::numbers::pi / 2;

/// Drives from `pose` in steps of 1 m, each 0.125 s; `scale`: measured over true distance.
PlanarPose drive(GlobalStart& start, PlanarPose pose, const std::vector<town::Leg>& legs,
                 double scale = 1) {
  const Eigen::Matrix3d noise = Eigen::Vector3d(1e-4, 1e-4, 1e-7).asDiagonal();
  const auto move = [&](const PlanarPose& motion) {
    pose = pose.compose(motion);
    start.move({scale * motion.x, scale * motion.y, motion.yaw}, noise, 0.125);
  };
  for (const town::Leg& leg : legs) {
    for (double driven = 0; driven < leg.length; ++driven) move({1, 0, 0});
    const int steps = static_cast<int>(std::ceil(6 * std::abs(leg.turn)));
    for (int i = 0; i < steps; ++i) move({1, 0, leg.turn / steps});
  }
  return pose;
}

town::Town irregular_town() { return town::build(town::irregular_streets()); }

TEST(StreetGrid, ReadsStreetsAndTheirWidth) {
  const town::Town town = town::build(town::lattice({0, 200}, {0, 100}));
  const StreetGrid grid(town.map);
  EXPECT_TRUE(grid.street(50, 0));
  EXPECT_TRUE(grid.street(0, 50));
  EXPECT_FALSE(grid.street(50, 50));
  EXPECT_FALSE(grid.street(1e7, -1e7));
  const auto profile = grid.across({50, 2, 0});
  ASSERT_TRUE(profile);
  EXPECT_NEAR(profile->centre(), -2, 0.6);
  EXPECT_NEAR(profile->half_width(), 3, 0.6);
  EXPECT_EQ(profile->distance(), 0);
  const auto aside = grid.across({50, -7, 0});
  ASSERT_TRUE(aside);
  EXPECT_NEAR(aside->distance(), 4, 0.8);
  EXPECT_FALSE(grid.across({50, 50, 0}));
  EXPECT_NEAR(grid.free_length({150, 0, 0}, 100), 53, 1.5);
}

/// A bridge from (200, -60) to (200, 60) over the street along y = 0, with a street to either end.
StreetPlan overpass() {
  StreetPlan plan;
  const auto add = [&](const Polyline& points, int layer, bool tunnel) {
    PlanStrip strip{{SegmentKind::kCarriageway, 1}, points, 3, 0.4};
    strip.layer = layer;
    strip.tunnel = tunnel;
    plan.strips.push_back(strip);
  };
  add({{0, 0}, {400, 0}}, 0, false);
  add({{200, -300}, {200, -60}}, 0, false);
  add({{200, -60}, {200, 60}}, 1, false);
  add({{200, 60}, {200, 300}}, 0, false);
  // Below the street a tunnel as well, with a street to either end.
  add({{300, -300}, {300, -60}}, 0, false);
  add({{300, -60}, {300, 60}}, -1, true);
  add({{300, 60}, {300, 300}}, 0, false);
  return plan;
}

TEST(StreetGrid, ALevelIsLeftOnlyWhereItIsJoined) {
  const town::Town town = town::build(overpass());
  const StreetGrid grid(town.map);
  // Drives a line in steps of 2 m, and returns the metres that are not on a street of the level
  // that it then has.
  const auto metres_off = [&](const Polyline& line) {
    int level = StreetGrid::kAnyLevel;
    double off = 0;
    for (size_t i = 1; i < line.size(); ++i) {
      const int count = static_cast<int>((line[i] - line[i - 1]).norm() / 2);
      const Eigen::Vector2d step = (line[i] - line[i - 1]) / count;
      for (int k = 1; k <= count; ++k) {
        const Eigen::Vector2d to = line[i - 1] + k * step;
        level = grid.level_after(level, to - step, to);
        if (!grid.street(to.x(), to.y(), level)) off += step.norm();
      }
    }
    return off;
  };
  for (const double side : {-1.0, 1.0}) {
    EXPECT_LT(metres_off({{5, 0}, {395, 0}}), 5);                       // below and above
    EXPECT_EQ(metres_off({{200, -290 * side}, {200, 290 * side}}), 0);  // over the bridge
    EXPECT_EQ(metres_off({{300, -290 * side}, {300, 290 * side}}), 0);  // through the tunnel
    // Up from below, until the bridge ends; down from the bridge; into the tunnel, and out of it.
    EXPECT_GT(metres_off({{5, 0}, {200, 0}, {200, 290 * side}}), 45);
    EXPECT_GT(metres_off({{200, 290 * side}, {200, 0}, {5, 0}}), 180);
    EXPECT_GT(metres_off({{395, 0}, {300, 0}, {300, 290 * side}}), 45);
    EXPECT_GT(metres_off({{300, 290 * side}, {300, 0}, {395, 0}}), 85);
  }
  // A long way between two comparisons: the joint lies on it.
  EXPECT_EQ(grid.level_after(0, {200, -90}, {200, -40}), 1);
  EXPECT_EQ(grid.level_after(0, {230, -40}, {200, -40}), 0);
}

TEST(StreetHypothesis, ItsCovarianceIsThatOfDeadReckoning) {
  // Straight on for 100 m in 10 s: the scale moves the end along, yaw and its rate across.
  StreetHypothesis hypothesis;
  hypothesis.covariance.diagonal() << 0, 0, 0.01 * 0.01, 0.02 * 0.02, 0.001 * 0.001;
  for (int i = 0; i < 1000; ++i) predict(hypothesis, {0.1, 0, 0}, Eigen::Matrix3d::Zero(), 0.01);
  EXPECT_NEAR(hypothesis.pose.x, 100, 1e-9);
  EXPECT_NEAR(std::sqrt(hypothesis.covariance(0, 0)), 2, 1e-6);
  // Across: 100 m · 0.01 rad, and half of 100 m · 10 s · 0.001 rad/s.
  EXPECT_NEAR(std::sqrt(hypothesis.covariance(1, 1)), std::hypot(1, 0.5), 1e-3);
  EXPECT_NEAR(std::sqrt(hypothesis.covariance(2, 2)), std::hypot(0.01, 0.01), 1e-9);
}

TEST(StreetHypothesis, OffTheStreetItLosesWeightAndIsCorrected) {
  const town::Town town = town::build(town::lattice({0, 200}, {0, 100}));
  const StreetGrid grid(town.map);
  StreetHypothesis beside, on;
  on.pose = {50, 2, 0};
  beside.pose = {50, 5, 0};
  beside.covariance.diagonal() << 4, 4, 0.01, 1e-4, 1e-6;
  on.covariance = beside.covariance;
  compare(on, grid, 1, {});
  compare(beside, grid, 1, {});
  EXPECT_EQ(on.misfit, 0);
  EXPECT_GT(beside.misfit, 0.3);
  EXPECT_LT(beside.log_weight, on.log_weight - 0.5);
  EXPECT_LT(beside.pose.y, 4.5);
  EXPECT_NEAR(beside.pose.x, 50, 1e-12);
  EXPECT_LT(beside.covariance(1, 1), 4);
  EXPECT_EQ(beside.covariance(0, 0), 4);
}

TEST(GlobalStart, FindsTheOnlyPlaceThatFits) {
  const town::Town town = irregular_town();
  GlobalStart start(town.map, {});
  start.restart();
  EXPECT_GT(start.hypotheses(), 500);
  const PlanarPose truth = drive(start, {20, -1, 0}, town::irregular_drive(), 1.01);
  const auto place = start.place();
  ASSERT_TRUE(place);
  EXPECT_TRUE(place->sure);
  EXPECT_LT(place->elsewhere, 0.01);
  const PlanarPose error = truth.motion_to(place->pose);
  EXPECT_LT(std::hypot(error.x, error.y), 5);
  EXPECT_LT(std::abs(error.yaw), 0.05);
  const Eigen::Vector2d d(place->pose.x - truth.x, place->pose.y - truth.y);
  EXPECT_LT(d.dot(place->covariance.topLeftCorner<2, 2>().inverse() * d), 9.21);
}

// A map with more streets than there may be hypotheses.
TEST(GlobalStart, OnALargeMapItBeginsWithThePlacesThatFitTheFirstTurn) {
  const town::Town town = irregular_town();
  GlobalStart start(town.map, {.max_hypotheses = 1000, .max_spacing = 4});
  start.restart();
  const std::vector<town::Leg> legs = town::irregular_drive();
  PlanarPose truth = drive(start, {20, -1, 0}, {legs.front()});
  EXPECT_FALSE(start.place());
  truth = drive(start, truth, {{60}});
  EXPECT_LT(start.hypotheses(), 1000);
  EXPECT_LT(start.behind(truth), 4);
  const double left = legs[1].length - 60;
  truth = drive(start, truth, {{left, legs[1].turn}, legs[2], legs[3], legs[4]});
  const auto place = start.place();
  ASSERT_TRUE(place);
  EXPECT_LT(place->elsewhere, 0.05);
  EXPECT_LT(place->misfit, 0.02);
  EXPECT_LT(std::hypot(place->pose.x - truth.x, place->pose.y - truth.y), 5);
  EXPECT_GT(start.driven(), 500);

  // A turn that no street has: it begins anew with a later one.
  start.restart();
  drive(start, {}, {{60, 2.2}, {8, -2.2}, {8, 2.2}, {80}});
  truth = drive(start, {20, -1, 0}, {legs[0], legs[1], legs[2], legs[3], legs[4]});
  ASSERT_TRUE(start.place());
  EXPECT_LT(start.behind(truth), 1);

  // What is believed needs no turn.
  start.restart(BelievedPlace{.pose = {20, -1, 0}});
  EXPECT_GT(start.hypotheses(), 0);
  EXPECT_TRUE(start.place());
}

TEST(GlobalStart, TellsThePlacesThatLookAlike) {
  // Two long carriageways, joined at both ends: turned by half a turn, the map is the same.
  const town::Town town = town::build(town::lattice({0, 400}, {0, 40}));
  GlobalStart start(town.map, {});
  start.restart();
  const PlanarPose truth = drive(start, {100, -1, 0}, {{294, kLeft}, {28, kLeft}, {200, 0}});
  const PlanarPose alike{400 - truth.x, 40 - truth.y, wrap_angle(truth.yaw + std::numbers::pi)};
  EXPECT_FALSE(start.place()->sure);
  const PossiblePlaces places = start.possible_places();
  ASSERT_EQ(places.all().size(), 2U);
  for (const PossiblePlace& place : places.all()) {
    EXPECT_NEAR(place.probability, 0.5, 0.2);
    EXPECT_TRUE(is_same_place(place.pose, truth, 8) || is_same_place(place.pose, alike, 8));
  }
  EXPECT_FALSE(is_same_place(places.all()[0].pose, places.all()[1].pose, 30));
}

TEST(GlobalStart, IsNotSureOfOneOfManyLikePlaces) {
  // Every block is alike: what is driven fits many of them, in any of four directions.
  const std::vector<double> every{0, 100, 200, 300, 400, 500, 600};
  const town::Town town = town::build(town::lattice(every, every));
  GlobalStart start(town.map, {});
  start.restart();
  drive(start, {20, -1, 0},
        {{74, kLeft}, {88, kRight}, {88, kLeft}, {88, kLeft}, {88, kRight}, {88}});
  const auto place = start.place();
  ASSERT_TRUE(place);
  EXPECT_FALSE(place->sure);
  EXPECT_GT(place->elsewhere, 0.8);
}

TEST(GlobalStart, EvidenceOfSensorsDecidesBetweenLikePlaces) {
  const town::Town town = town::build(town::alike_blocks());
  GlobalStart start(town.map, {});
  start.restart();
  PlanarPose truth{20, -1, 0};
  for (const town::Leg& leg : town::alike_drive()) {
    truth = drive(start, truth, {leg});
    if (start.hypotheses() > 48) continue;
    start.weigh([&](const PlanarPose& pose) {
      return std::hypot(pose.x - truth.x, pose.y - truth.y) < 10 ? 4.0 : 0.0;
    });
  }
  const auto place = start.place();
  ASSERT_TRUE(place);
  EXPECT_LT(std::hypot(place->pose.x - truth.x, place->pose.y - truth.y), 5);
  EXPECT_LT(place->elsewhere, 0.01);
  EXPECT_EQ(start.behind(truth), 0);
  EXPECT_TRUE(std::isinf(start.behind({1e5, 0, 0})));
  // Likelier than the truth is nothing; likelier than a pose 30 m off is the truth, if within
  // reach.
  EXPECT_FALSE(start.better_near(truth, 100, 4, 0.02));
  const PlanarPose off = truth.compose({30, 0, 0});
  const auto better = start.better_near(off, 60, 4, 0.02);
  ASSERT_TRUE(better);
  EXPECT_LT(std::hypot(better->pose.x - truth.x, better->pose.y - truth.y), 5);
  EXPECT_FALSE(start.better_near(off, 15, 4, 0.02));
}

// Where all blocks are alike, the one that is believed in is e^3 likelier than any other, no more.
TEST(GlobalStart, ABelievedPoseDecidesBetweenLikePlaces) {
  const std::vector<double> every{0, 100, 200, 300, 400, 500, 600};
  const town::Town town = town::build(town::lattice(every, every));
  const PlanarPose begin{220, 199, 0};
  for (const bool believed : {false, true}) {
    GlobalStart start(town.map, {.believed_radius = 40});
    start.restart(believed ? std::optional(BelievedPlace{begin}) : std::nullopt);
    const PlanarPose truth = drive(start, begin, {{74, kLeft}, {88, kRight}, {60}});
    EXPECT_LT(start.behind(truth), believed ? 0.5 : 1.5);
    const double other = start.behind(truth.compose({-100, 0, 0}));
    EXPECT_NEAR(other - start.behind(truth), believed ? 3 : 0, 1.5);
  }
}

TEST(GlobalStart, ATurnWhileAloneIsWorthAWay) {
  const town::Town town = irregular_town();
  double at_turn[2] = {}, after[2] = {};
  for (const size_t counts : {0U, 1U}) {
    GlobalStart start(town.map, {.turn_worth = counts > 0 ? 40.0 : 0.0});
    start.restart();
    PlanarPose pose = drive(start, {20, -1, 0}, town::irregular_drive());
    ASSERT_LT(start.place()->elsewhere, 0.01);
    const double before = start.place()->alone;
    // Heading west, left at x = 160, and 60 m on. It counts once its streets lie behind.
    pose = drive(start, pose, {{pose.x - 166, kLeft}});
    at_turn[counts] = start.place()->alone - before;
    drive(start, pose, {{60}});
    after[counts] = start.place()->alone - before;
  }
  EXPECT_NEAR(at_turn[0], at_turn[1], 1e-6);
  EXPECT_NEAR(after[1] - after[0], 40 * kLeft, 15);
}

TEST(GlobalStart, FindsNoTurnBetweenTheLevelsOfAnOverpass) {
  // The drive turns left after 180 m; so does the map if the bridge is a crossing.
  for (const bool crossing : {false, true}) {
    StreetPlan plan = overpass();
    for (PlanStrip& strip : plan.strips) strip.layer = crossing ? 0 : strip.layer;
    const town::Town town = town::build(plan);
    GlobalStart start(town.map, {});
    start.restart();
    const PlanarPose truth = drive(start, {20, -1, 0}, {{176, kLeft}, {150}});
    if (!crossing) {
      EXPECT_LT(start.driven(), 300);  // no street explained it, and the search began anew
      continue;
    }
    ASSERT_TRUE(start.place());
    EXPECT_LT(start.place()->misfit, 0.02);
    EXPECT_LT(start.behind(truth), 3);
  }
  // Straight over the bridge and straight below it the place is kept.
  const town::Town town = town::build(overpass());
  for (const PlanarPose& begin : {PlanarPose{201, -280, kLeft}, {20, -1, 0}, {301, -280, kLeft}}) {
    GlobalStart start(town.map, {});
    start.restart();
    const PlanarPose truth = drive(start, begin, {{340}});
    EXPECT_LT(start.behind(truth), 6) << begin.x;
  }
}

TEST(GlobalStart, IsNotSureOnAStraightStreet) {
  const town::Town town = irregular_town();
  GlobalStart start(town.map, {});
  start.restart();
  drive(start, {20, -1, 0}, {{600}});
  const auto place = start.place();
  ASSERT_TRUE(place);
  EXPECT_FALSE(place->sure);
}

TEST(GlobalStart, IsNotSureBesideTheStreetsOfTheMap) {
  const town::Town town = irregular_town();
  GlobalStart start(town.map, {});
  start.restart();
  // Nothing on the map bends like this.
  for (int i = 0; i < 6; ++i) {
    drive(start, {}, {{30, 0.7}, {45, -1.9}, {60, 1.1}, {25, 0.6}});
    const auto place = start.place();
    EXPECT_FALSE(place && place->sure);
  }
  EXPECT_LT(start.driven(), 1000);  // it began anew
  EXPECT_GT(start.hypotheses(), 0);
}

TEST(GlobalStart, StandingChangesNothing) {
  const town::Town town = irregular_town();
  GlobalStart start(town.map, {});
  start.restart();
  drive(start, {20, -1, 0}, {{134, kLeft}, {60}});
  const auto before = start.place();
  for (int i = 0; i < 1200; ++i) start.move({}, 1e-4 * Eigen::Matrix3d::Identity(), 0.1);
  const auto after = start.place();
  ASSERT_TRUE(before && after);
  EXPECT_EQ(before->pose, after->pose);
  EXPECT_EQ(before->elsewhere, after->elsewhere);
}

TEST(GlobalStart, AMapWithoutStreetsHasNoPlace) {
  StreetPlan plan;
  plan.areas.push_back({{SegmentKind::kGreen, 1}, {{{0, 0}, {90, 0}, {90, 90}, {0, 90}}}});
  const town::Town town = town::build(plan);
  GlobalStart start(town.map, {});
  start.restart();
  drive(start, {}, {{100}});
  EXPECT_FALSE(start.place());
  EXPECT_EQ(start.hypotheses(), 0);
}

TEST(GlobalStart, TheNumberOfHypothesesIsBounded) {
  const town::Town town = irregular_town();
  GlobalStart start(town.map, {.max_hypotheses = 1000});
  start.restart();
  EXPECT_GT(start.hypotheses(), 400);
  EXPECT_LT(start.hypotheses(), 1000);
}

}  // namespace
}  // namespace infuse::streetmap

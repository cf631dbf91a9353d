#include "fusion/streetmap/tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/fusion/streetmap/town.hpp"
#include "tests/fusion/streetmap/tracker_drive.hpp"

namespace infuse::streetmap {
namespace {

TEST(Tracker, ConvergesFromFourMetresAway) {
  int found = 0;
  for (const uint64_t seed : {1U, 2U, 3U, 4U}) {
    TrackerOptions options = fast_options();
    options.seed = seed;
    options.particles.max_count = 400;
    Tracker tracker(shared_town().map, options);
    const double a = 1.3 * static_cast<double>(seed);
    const DriveResult driven =
        drive(tracker, {4 * std::cos(a), 4 * std::sin(a), 0.05}, 4, seed, 36);
    // The scale error of 2 % amounts to 1.4 m along the street.
    found += std::abs(driven.last.x - driven.truth.x) < 1.6 &&
             std::abs(driven.last.y - driven.truth.y) < 0.7;
  }
  EXPECT_EQ(found, 4);
}

TEST(Tracker, AStartThatNothingMatchesIsNeverTracking) {
  Tracker tracker(shared_town().map, fast_options());
  const PlanarPose pose{-60, 0, 0};
  tracker.start(pose, covariance(1, 0.05));
  for (uint64_t i = 0; i < 40; ++i) {
    tracker.predict({0.5, 0, 0}, covariance(0.01, 0.001), kUpdatePeriod);
    tracker.update(sample_view(shared_town().map, pose, i, true));
    EXPECT_NE(tracker.estimate().state, TrackState::kTracking) << i;
  }
  EXPECT_STRNE(tracker.estimate().reason, "");
}

// An honest start: UNSURE until the place is found, and never LOST.
TEST(Tracker, AWideStartIsFound) {
  int found = 0;
  for (const uint64_t seed : {1U, 2U, 3U, 4U}) {
    TrackerOptions options = fast_options();
    options.seed = seed;
    options.particles.max_count = 800;
    Tracker tracker(shared_town().map, options);
    PlanarPose truth{-80, -1.2, 0.02};
    const double direction = 1.5 * static_cast<double>(seed);
    tracker.start(truth.compose({8 * std::cos(direction), 8 * std::sin(direction), 0.1}),
                  covariance(seed == 4 ? 20 : 8, 0.15));
    int tracking = 0, within = 0;
    for (int i = 0; i < 34; ++i) {
      truth = truth.compose({2, 0, truth.yaw < 0.5 ? -0.05 * truth.yaw : 0});
      tracker.predict({2, 0, -0.05 * truth.yaw}, covariance(0.02, 0.002), kUpdatePeriod);
      tracker.update(sample_view(shared_town().map, truth, seed * 1000 + static_cast<uint64_t>(i)));
      const TrackerEstimate estimate = tracker.estimate();
      EXPECT_NE(estimate.state, TrackState::kLost) << seed << " " << estimate.reason;
      if (estimate.state != TrackState::kTracking) continue;
      ++tracking;
      const Eigen::Vector2d d(estimate.pose.x - truth.x, estimate.pose.y - truth.y);
      const Eigen::Matrix2d C = estimate.covariance.topLeftCorner<2, 2>();
      within += d.dot(C.inverse() * d) < 9.21;
    }
    found += tracking > 5;
    EXPECT_GE(within, tracking * 97 / 100) << seed;
  }
  EXPECT_GE(found, 3);
}

// 20 m further along the same street with a stated sigma of 1 m: no particle is near the truth.
TEST(Tracker, AStartFurtherAlongTheStreetIsNeverSureAndWrong) {
  for (const bool gnss : {false, true}) {
    int found = 0;
    for (const uint64_t seed : {1U, 2U}) {
      TrackerOptions options = fast_options();
      options.seed = seed;
      options.particles.max_count = 400;
      Tracker tracker(shared_town().map, options);
      const double ahead = seed % 2 == 0 ? 20 : -20;
      const DriveResult driven = drive(tracker, {ahead, 0, 0}, 1, seed, 70, gnss);
      found += driven.state == TrackState::kTracking &&
               std::hypot(driven.last.x - driven.truth.x, driven.last.y - driven.truth.y) < 2;
      EXPECT_LE(driven.tracking - driven.within, 1) << seed << gnss;
    }
    EXPECT_EQ(found, 2) << gnss;
  }
}

// 100 m further along, beyond the labels around the particles: the place that GNSS proposes is
// judged by the labels there.
TEST(Tracker, GnssLeadsBackFromFarAway) {
  TrackerOptions options = fast_options();
  options.global_start.enabled = false;
  options.gnss.doubt_seconds = 1;
  options.gnss.lost_seconds = 3;
  options.particles.max_count = 400;
  Tracker tracker(shared_town().map, options);
  const DriveResult driven = drive(tracker, {100, 0, 0}, 1, 3, 75, true);
  EXPECT_EQ(driven.state, TrackState::kTracking);
  EXPECT_LT(std::hypot(driven.last.x - driven.truth.x, driven.last.y - driven.truth.y), 2);
  EXPECT_LE(driven.tracking - driven.within, 1);
}

// 3 km off the map, with good fixes: back within 15 s.
TEST(Tracker, FixesLeadBackToTheMap) {
  for (const uint64_t seed : {1U, 2U, 3U}) {
    TrackerOptions options = fast_options();
    options.seed = seed;
    Tracker tracker(shared_town().map, options);
    const DriveResult driven = drive(tracker, {3000, 0, 0}, 1, seed, 60, true);
    EXPECT_EQ(driven.state, TrackState::kTracking) << seed << tracker.estimate().reason;
    EXPECT_LT(std::hypot(driven.last.x - driven.truth.x, driven.last.y - driven.truth.y), 2);
    EXPECT_LE(driven.tracking - driven.within, 1) << seed;
  }
}

TEST(Tracker, AGivenStartIsUnsureUntilAlongAndAcrossAreConfirmed) {
  TrackerOptions options = fast_options();
  options.novelty_distance = 20;
  Tracker tracker(shared_town().map, options);
  const DriveResult driven = drive(tracker, {0.3, 0.2, 0}, 0.5, 5);
  EXPECT_TRUE(driven.places_named);
  EXPECT_GT(driven.first_tracking, options.confidence.window / 2);
  EXPECT_EQ(driven.state, TrackState::kTracking);
  EXPECT_LT(tracker.estimate().elsewhere, 0.02);
}

// All streets are searched by the drive alone; what is found is then confirmed by the sensors.
TEST(Tracker, StartsFromNothingOnceOnePlaceFitsTheDrive) {
  const town::Town town = town::build(town::irregular_streets());
  Tracker tracker(town.map, fast_options());
  PlanarPose truth{20, -1, 0};
  int sweeps = 0, tracking = 0;
  bool started = false;
  for (const auto& [length, turn] : town::irregular_drive()) {
    const int steps = static_cast<int>(std::ceil(6 * std::abs(turn)));
    for (int i = 0; i < static_cast<int>(length) + steps; ++i) {
      const PlanarPose motion{1, 0, i < static_cast<int>(length) ? 0 : turn / steps};
      truth = truth.compose(motion);
      tracker.predict({1.01, 0, motion.yaw}, covariance(0.01, 0.001), Duration(125'000'000));
      if (++sweeps % 4 != 0) continue;
      tracker.update(sample_view(town.map, truth, static_cast<uint64_t>(sweeps)));
      const TrackerEstimate estimate = tracker.estimate();
      if (!tracker.started()) {
        EXPECT_EQ(estimate.state, TrackState::kLost);
        EXPECT_STREQ(estimate.reason, "no initial pose, searching all streets");
        EXPECT_GT(estimate.hypotheses, 0);
        continue;
      }
      started = true;
      const PlanarPose error = truth.motion_to(estimate.pose);
      if (estimate.state == TrackState::kTracking) {
        ++tracking;
        EXPECT_LT(std::hypot(error.x, error.y), 4);
      }
    }
  }
  EXPECT_TRUE(started);
  EXPECT_GT(tracking, 10);
}

// By odometry alone eight places fit; parks beside the streets decide.
TEST(Tracker, WhereBlocksAreAlikeTheSensorsDecide) {
  const town::Town town = town::build(town::alike_blocks());
  for (const int witnessed : {0, 48}) {
    TrackerOptions options = fast_options();
    options.global_start.max_witnessed = witnessed;
    Tracker tracker(town.map, options);
    PlanarPose truth{20, -1, 0};
    int sweeps = 0;
    for (const auto& [length, turn] : town::alike_drive()) {
      const int steps = static_cast<int>(std::ceil(6 * std::abs(turn)));
      for (int i = 0; i < static_cast<int>(length) + steps; ++i) {
        const PlanarPose motion{1, 0, i < static_cast<int>(length) ? 0 : turn / steps};
        truth = truth.compose(motion);
        tracker.predict(motion, covariance(0.01, 0.001), Duration(125'000'000));
        if (++sweeps % 8 != 0) continue;
        tracker.update(sample_view(town.map, truth, static_cast<uint64_t>(sweeps)));
      }
    }
    EXPECT_EQ(tracker.started(), witnessed > 0);
    if (!tracker.started()) continue;
    const PlanarPose error = truth.motion_to(tracker.estimate().pose);
    EXPECT_LT(std::hypot(error.x, error.y), 4);
  }
}

// Of few satellites too: fixes rule streets out long before turns do.
TEST(Tracker, FixesShortenTheSearchOfAllStreets) {
  const town::Town town = town::build(town::irregular_streets());
  double started_after[2] = {1e9, 1e9};
  for (const bool gnss : {false, true}) {
    Tracker tracker(town.map, fast_options());
    PlanarPose truth{20, -1, 0};
    int sweeps = 0;
    for (const auto& [length, turn] : town::irregular_drive()) {
      const int steps = static_cast<int>(std::ceil(6 * std::abs(turn)));
      for (int i = 0; i < static_cast<int>(length) + steps && !tracker.started(); ++i) {
        const PlanarPose motion{1, 0, i < static_cast<int>(length) ? 0 : turn / steps};
        truth = truth.compose(motion);
        tracker.predict({1.01, 0, motion.yaw}, covariance(0.01, 0.001), Duration(125'000'000));
        if (gnss && sweeps % 8 == 0) tracker.add_fix({{truth.x + 15, truth.y - 10}, {}, 10});
        if (++sweeps % 4 != 0) continue;
        tracker.update(sample_view(town.map, truth, static_cast<uint64_t>(sweeps)));
      }
    }
    ASSERT_TRUE(tracker.started());
    const PlanarPose error = truth.motion_to(tracker.estimate().pose);
    EXPECT_LT(std::hypot(error.x, error.y), 12) << gnss;
    started_after[gnss] = sweeps;
  }
  EXPECT_LT(started_after[true], 0.75 * started_after[false]);
}

TEST(Tracker, IsLostBeforeItsStart) {
  Tracker tracker(shared_town().map, fast_options());
  tracker.update(sample_view(shared_town().map, {0, 0, 0}, 1));
  EXPECT_FALSE(tracker.estimate().usable());
  EXPECT_STREQ(tracker.estimate().reason, "no initial pose");
}

}  // namespace
}  // namespace infuse::streetmap

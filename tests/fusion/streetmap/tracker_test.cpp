#include "fusion/streetmap/tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "tests/fusion/streetmap/town.hpp"

namespace infuse::streetmap {
namespace {

using town::sample_view;

constexpr Duration kUpdatePeriod{250'000'000};

const town::Town& shared_town() {
  static const town::Town kTown = town::build(town::plan());
  return kTown;
}

TrackerOptions fast_options() {
  TrackerOptions options;
  options.fit.centres = 25;
  options.fit.sigmas = {1.0, 2.0};
  options.fit.lambdas = {1e-3, 1e-1};
  options.novelty_distance = 0.5;        // each view of the town is independent
  options.particles.scale_sigma = 0.02;  // matches the error of the odometry
  options.particles.distance_noise = 0.03;
  options.particles.yaw_noise = 0.0015;
  options.particles.min_count = 60;
  options.particles.max_count = 250;
  return options;
}

Eigen::Matrix3d covariance(double metres, double yaw) {
  return Eigen::Vector3d(metres * metres, metres * metres, yaw * yaw).asDiagonal();
}

/// Result of a drive along the first street and into the second.
struct DriveResult {
  double rms = 0;      ///< m, after the first ten updates
  double yaw_rms = 0;  ///< rad
  int tracking = 0, updates = 0, within = 0, first_tracking = -1;
  bool places_named = false;  ///< a reason named a place along, across or elsewhere
  PlanarPose truth, last;
  TrackState state = TrackState::kLost;
};

/// 60 updates of 2 m with a turn at the crossing. The odometry has a scale error of 2 % and a yaw
/// bias of 0.1° per update.
DriveResult drive(Tracker& tracker, const PlanarPose& start_error, double sigma, uint64_t seed,
                  int updates = 60, bool gnss = false) {
  DriveResult driven;
  PlanarPose truth{-80, -1.2, 0.02};
  const PlanarPose initial_pose = truth.compose(start_error);
  tracker.start(initial_pose, covariance(sigma, 0.06));
  double sum = 0, yaw_sum = 0;
  int counted = 0;
  for (int i = 0; i < updates; ++i) {
    const bool turning = truth.x > -6 && truth.yaw < 1.5;
    const PlanarPose motion{2, 0, turning ? 0.35 : (truth.yaw < 0.5 ? -0.05 * truth.yaw : 0)};
    truth = truth.compose(motion);
    tracker.predict({motion.x * 1.02, motion.y, motion.yaw + 0.0017}, covariance(0.02, 0.002),
                    kUpdatePeriod);
    tracker.update(sample_view(shared_town().map, truth, seed * 1000 + static_cast<uint64_t>(i)));
    if (gnss) tracker.add_fix({{truth.x + 2, truth.y - 1.5}, {}, 1});
    const TrackerEstimate estimate = tracker.estimate();
    const PlanarPose error = truth.motion_to(estimate.pose);
    ++driven.updates;
    driven.places_named |= std::strstr(estimate.reason, "not confirmed") != nullptr;
    if (estimate.state == TrackState::kTracking) {
      if (driven.first_tracking < 0) driven.first_tracking = i;
      ++driven.tracking;
      const Eigen::Vector2d d(estimate.pose.x - truth.x, estimate.pose.y - truth.y);
      const Eigen::Matrix2d C = estimate.covariance.topLeftCorner<2, 2>();
      driven.within += d.dot(C.inverse() * d) < 9.21;  // χ² of two, 99 %
    }
    if (i < 10) continue;
    ++counted;
    sum += error.x * error.x + error.y * error.y;
    yaw_sum += error.yaw * error.yaw;
  }
  driven.rms = std::sqrt(sum / counted);
  driven.yaw_rms = std::sqrt(yaw_sum / counted);
  driven.truth = truth;
  driven.last = tracker.estimate().pose;
  driven.state = tracker.estimate().state;
  return driven;
}

TEST(Tracker, FollowsADriveRoundACorner) {
  for (const uint64_t seed : {1U, 2U, 3U}) {
    TrackerOptions options = fast_options();
    options.seed = seed;
    Tracker tracker(shared_town().map, options);
    const DriveResult driven = drive(tracker, {0.8, -0.6, 0.03}, 1, seed);
    EXPECT_LT(driven.rms, 0.8) << seed;  // dead reckoning: several metres
    EXPECT_LT(driven.yaw_rms, 0.03) << seed;
    EXPECT_GT(driven.tracking, driven.updates * 3 / 4) << seed;
    EXPECT_GE(driven.within, driven.tracking * 97 / 100) << seed;
    EXPECT_TRUE(tracker.estimate().usable());
    EXPECT_LT(tracker.estimate().p_value, 0.05);
  }
}

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

TEST(Tracker, TheSameSeedGivesTheSamePoses) {
  PlanarPose poses[3];
  for (int i = 0; i < 3; ++i) {
    TrackerOptions options = fast_options();
    options.seed = i < 2 ? 7 : 8;
    Tracker tracker(shared_town().map, options);
    poses[i] = drive(tracker, {0.5, 0.5, 0}, 1, 9, 12).last;
  }
  EXPECT_EQ(poses[0], poses[1]);
  EXPECT_NE(poses[0], poses[2]);
}

// A confirmed place, then 60 m where the map says nothing of what is seen, then the map again.
TEST(Tracker, TheWantOfEvidenceLosesNothing) {
  Tracker tracker(shared_town().map, fast_options());
  PlanarPose truth = drive(tracker, {0, 0, 0}, 0.5, 1, 25).truth;
  ASSERT_EQ(tracker.estimate().state, TrackState::kTracking);
  const double known = tracker.estimate().covariance.topLeftCorner<2, 2>().trace();
  double widest = 0;
  int lost = 0, unsure = 0, outside = 0;
  for (uint64_t i = 0; i < 90; ++i) {
    const bool blind = i < 60;
    const double step = i < 30 ? 1 : i < 60 ? -1 : 0.5;  // there and back
    truth = truth.compose({step, 0, 0});
    tracker.predict({step, 0, 0}, covariance(0.05, 0.001), kUpdatePeriod);
    tracker.update(sample_view(shared_town().map, truth, 3000 + i, blind));
    const TrackerEstimate estimate = tracker.estimate();
    lost += estimate.state == TrackState::kLost;
    unsure += blind && estimate.state == TrackState::kUnsure;
    const Eigen::Vector2d d(estimate.pose.x - truth.x, estimate.pose.y - truth.y);
    const Eigen::Matrix2d C = estimate.covariance.topLeftCorner<2, 2>();
    outside += estimate.state == TrackState::kTracking && d.dot(C.inverse() * d) > 9.21;
    if (blind) widest = std::max(widest, C.trace());
  }
  EXPECT_EQ(lost, 0);
  EXPECT_GT(unsure, 20);
  EXPECT_GT(widest, 1.2 * known) << "the region grows by odometry";
  EXPECT_LE(outside, 1);
  EXPECT_EQ(tracker.estimate().state, TrackState::kTracking);
  EXPECT_LT(std::hypot(tracker.estimate().pose.x - truth.x, tracker.estimate().pose.y - truth.y),
            1);
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

// Off the map by its eastern edge, and back: the region follows odometry there.
TEST(Tracker, ReturnsToTheMapByOdometry) {
  const town::Town& town = shared_town();
  const double edge =
      town.map.frame().min_corner.x() + town.map.columns() * town.map.frame().cell_size;
  Tracker tracker(town.map, fast_options());
  PlanarPose truth{100, -1.2, 0};
  tracker.start(truth, covariance(0.5, 0.03));
  uint64_t view = 0;
  bool was_outside = false, was_tracking = false;
  const auto go = [&](double step, double until) {
    while ((until - truth.x) * step > 0) {
      truth = truth.compose({step, 0, 0});
      tracker.predict({step, 0, 0}, covariance(0.02, 5e-4), kUpdatePeriod);
      tracker.update(sample_view(town.map, truth, 5000 + view++));
      const TrackerEstimate estimate = tracker.estimate();
      was_tracking |= estimate.state == TrackState::kTracking;
      EXPECT_FALSE(was_tracking && estimate.state == TrackState::kLost) << truth.x;
      was_outside |= !estimate.on_map;
    }
  };
  go(-1, 60);
  go(2, edge + 20);
  EXPECT_TRUE(was_tracking);
  EXPECT_TRUE(was_outside);
  go(-2, -70);
  EXPECT_LT(std::hypot(tracker.estimate().pose.x - truth.x, tracker.estimate().pose.y - truth.y),
            2);
  EXPECT_EQ(tracker.estimate().state, TrackState::kTracking) << tracker.estimate().reason;
}

TEST(Tracker, RecoversAfterAJump) {
  TrackerOptions options = fast_options();
  options.particles.max_count = 600;
  Tracker tracker(shared_town().map, options);
  drive(tracker, {0, 0, 0}, 0.5, 1, 20);
  // Displaced 7 m backwards and sideways, unnoticed by the odometry.
  PlanarPose truth = tracker.estimate().pose.compose({-6, 1.5, 0});
  double worst = 0;
  bool doubted = false;
  for (int i = 0; i < 60; ++i) {
    truth = truth.compose({0.7, 0, 0});
    tracker.predict({0.7, 0, 0}, covariance(0.02, 0.002), kUpdatePeriod);
    tracker.update(sample_view(shared_town().map, truth, 500 + static_cast<uint64_t>(i)));
    const auto estimate = tracker.estimate();
    doubted |= estimate.state != TrackState::kTracking;
    if (i >= 50) {
      worst = std::max(worst, std::hypot(estimate.pose.x - truth.x, estimate.pose.y - truth.y));
    }
  }
  EXPECT_TRUE(doubted);
  EXPECT_LT(worst, 1.2);
  EXPECT_EQ(tracker.estimate().state, TrackState::kTracking);
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

// Two minutes; the yaw rate of the odometry is within its noise.
TEST(Tracker, NoBiasMovesAVehicleThatStands) {
  Tracker tracker(shared_town().map, fast_options());
  const DriveResult driven = drive(tracker, {0, 0, 0}, 0.5, 1, 40);
  const TrackerEstimate before = tracker.estimate();
  for (int i = 0; i < 480; ++i) {
    tracker.predict({0, 0, i % 2 == 0 ? 1e-4 : -1e-4}, covariance(0.005, 5e-4), kUpdatePeriod);
  }
  const TrackerEstimate after = tracker.estimate();
  EXPECT_NEAR(after.pose.yaw, before.pose.yaw, 1e-6);
  EXPECT_NEAR(after.covariance(2, 2), before.covariance(2, 2), 1e-9);
  // GNSS is judged while the vehicle stands.
  for (int i = 0; i < 100; ++i) {
    tracker.predict({}, Eigen::Matrix3d::Zero(), kUpdatePeriod);
    tracker.add_fix({{driven.truth.x + 60, driven.truth.y}, {}, 1});
    if (i == 30) {
      EXPECT_EQ(tracker.estimate().state, TrackState::kUnsure);
    }
  }
  EXPECT_EQ(tracker.estimate().state, TrackState::kLost);
  EXPECT_STREQ(tracker.estimate().reason, "GNSS fixes contradict the pose on the map");
}

TEST(Tracker, StandingStillIsNoEvidence) {
  Tracker tracker(shared_town().map, fast_options());
  const DriveResult driven = drive(tracker, {0, 0, 0}, 0.5, 1, 20);
  const Eigen::Matrix3d spread = tracker.estimate().covariance;
  for (uint64_t i = 0; i < 50; ++i) {
    tracker.predict({}, Eigen::Matrix3d::Zero(), kUpdatePeriod);
    tracker.update(sample_view(shared_town().map, driven.truth, 77));
  }
  EXPECT_NEAR(tracker.estimate().covariance.trace(), spread.trace(), 0.01);
  EXPECT_NEAR(std::hypot(tracker.estimate().pose.x - driven.last.x,
                         tracker.estimate().pose.y - driven.last.y),
              0, 0.02);
}

// On a ferry, or with wheels that do not turn: odometry stands, and what is seen goes by.
TEST(Tracker, IsNotSureWhileItIsCarried) {
  for (const bool carried : {false, true}) {
    Tracker tracker(shared_town().map, fast_options());
    PlanarPose truth = drive(tracker, {0, 0, 0}, 0.5, 1, 25).truth;
    int tracking = 0;
    for (uint64_t i = 0; i < 60; ++i) {
      if (carried && i >= 20) truth = truth.compose({1.5, 0, 0});
      tracker.predict({}, Eigen::Matrix3d::Zero(), kUpdatePeriod);
      tracker.update(sample_view(shared_town().map, truth, 7000 + i));
      tracking += tracker.estimate().state == TrackState::kTracking;
    }
    if (carried) {
      EXPECT_LT(tracking, 40);
      EXPECT_STREQ(tracker.estimate().reason,
                   "the view changes although odometry says that the vehicle stands");
    } else {
      EXPECT_EQ(tracking, 60);
    }
  }
}

TEST(Tracker, IsLostOutsideTheMap) {
  Tracker tracker(shared_town().map, fast_options());
  tracker.start({5000, 5000, 0}, covariance(1, 0.05));
  tracker.update(sample_view(shared_town().map, {0, 0, 0}, 1));
  EXPECT_EQ(tracker.estimate().state, TrackState::kLost);
  EXPECT_STREQ(tracker.estimate().reason, "the vehicle is outside the map");
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

TEST(Tracker, TooFewSamplesChangeNothing) {
  Tracker tracker(shared_town().map, fast_options());
  tracker.start({0, 0, 0}, covariance(1, 0.05));
  const PlanarPose before = tracker.estimate().pose;
  tracker.update(GridSamples{});
  EXPECT_EQ(tracker.estimate().pose, before);
}

TEST(TrackerEstimate, CovarianceIsALeftPerturbation) {
  // Compares poses drawn from the planar covariance with exp(xi) · T, xi from the 6 × 6 covariance.
  TrackerEstimate estimate;
  estimate.pose = {30, -20, 0.7};
  estimate.covariance << 0.09, 0.02, 0.001, 0.02, 0.16, -0.002, 0.001, -0.002, 0.0004;
  const geometry::Matrix6 C = estimate.pose_covariance();
  const Eigen::Matrix3d L = estimate.covariance.llt().matrixL();
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  geometry::Matrix6 sum = geometry::Matrix6::Zero();
  const int n = 40000;
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector3d d = L * Eigen::Vector3d(normal(random), normal(random), normal(random));
    TrackerEstimate other;
    other.pose = {30 + d.x(), -20 + d.y(), 0.7 + d.z()};
    const geometry::Vector6 xi =
        geometry::log(other.T_map_vehicle() * estimate.T_map_vehicle().inverse());
    sum += xi * xi.transpose();
  }
  for (const int i : {2, 3, 4}) {
    for (const int k : {2, 3, 4}) {
      EXPECT_NEAR(sum(i, k) / n, C(i, k), 0.03 * std::sqrt(C(i, i) * C(k, k))) << i << k;
    }
  }
}

TEST(TrackerOptions, ReportsInvalidValues) {
  EXPECT_FALSE(TrackerOptions().invalid());
  EXPECT_TRUE(TrackerOptions{.skipped_validation_share = 1.5}.invalid());
  EXPECT_TRUE(TrackerOptions{.sharpness = 0}.invalid());
  TrackerOptions few;
  few.particles.min_count = 1;
  EXPECT_TRUE(few.invalid());
  TrackerOptions window;
  window.confidence.window = 0;
  EXPECT_TRUE(window.invalid());
  TrackerOptions grid;
  grid.grid.cell_size = 0;
  EXPECT_TRUE(grid.invalid());
}

}  // namespace
}  // namespace infuse::streetmap

#include "fusion/streetmap/tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/fusion/streetmap/town.hpp"
#include "tests/fusion/streetmap/tracker_drive.hpp"

namespace infuse::streetmap {
namespace {

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

#include "fusion/calibration/pose_drift.hpp"

#include <gtest/gtest.h>

#include "tests/fusion/calibration/drawn_calibrations.hpp"

namespace infuse::calibration {
namespace {

using geometry::Vector6;

/// Calibrations of drives ten days apart; `moved(i)` is the motion of the camera at the i-th.
template <class Moved>
std::vector<DatedCalibration> history(std::mt19937_64& random, int drives, const Moved& moved,
                                      double excess = 1) {
  std::vector<DatedCalibration> calibrations;
  for (int i = 0; i < drives; ++i) {
    calibrations.push_back(
        drawn::calibration(random, geometry::exp(moved(i)) * drawn::mount(), 10.0 * i, excess));
  }
  return calibrations;
}

Vector6 still(int) { return Vector6::Zero(); }

TEST(PoseDrift, CamerasThatDoNotMoveHaveOnePose) {
  std::mt19937_64 random(1);
  int drifts = 0, one_pose = 0;
  double squared = 0;
  constexpr int kTrials = 300;
  for (int trial = 0; trial < kTrials; ++trial) {
    const PoseHistory found =
        find_pose_drift(history(random, 6, still), drawn::mount(), {.significance = 0.05});
    drifts += found.verdict == PoseVerdict::kDrift;
    one_pose += found.verdict == PoseVerdict::kOnePose;
    ASSERT_TRUE(found.usable());
    const Vector6 error = geometry::log(found.current.T_camera_lidar * drawn::mount().inverse());
    squared += error.dot(found.current.covariance.llt().solve(error));
  }
  EXPECT_LE(drifts, 0.05 * kTrials);  // of those that χ² finds to differ, Bonferroni leaves fewer
  EXPECT_GE(one_pose, 0.91 * kTrials);
  EXPECT_LT(squared / kTrials, 7);
}

TEST(PoseDrift, AStepIsDatedAndItsAxisNamed) {
  std::mt19937_64 random(2);
  int dated = 0, named = 0;
  constexpr int kTrials = 100;
  for (int trial = 0; trial < kTrials; ++trial) {
    const int begins = 1 + trial % 5;
    const auto moved = [&](int i) {
      return i < begins ? Vector6::Zero().eval() : Vector6(0.007 * Vector6::Unit(1));  // 0.4°
    };
    const PoseHistory found = find_pose_drift(history(random, 6, moved), drawn::mount(), {});
    if (found.verdict != PoseVerdict::kDrift) continue;  // counted below
    const PoseChange& change = found.changes.front();
    dated += change.kind == ChangeKind::kStep && change.first == static_cast<size_t>(begins);
    named += change.axis == 1;
    EXPECT_NEAR(change.change(1), 0.007, 5 * change.sigma(1));
    const Vector6 error = geometry::log(found.current.T_camera_lidar *
                                        (geometry::exp(moved(5)) * drawn::mount()).inverse());
    EXPECT_LT(error.dot(found.current.covariance.llt().solve(error)), 33);  // one in 10⁵
  }
  EXPECT_GE(dated, 95);
  EXPECT_GE(named, 95);
}

TEST(PoseDrift, ASteadyDriftBeginsWhereItLeavesTheOldPose) {
  std::mt19937_64 random(3);
  int ramps = 0, dated = 0;
  constexpr int kTrials = 100;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto moved = [](int i) {  // 8 mm a drive upwards, from the third of ten on
      return Vector6(-0.008 * std::max(0, i - 2) * Vector6::Unit(4));
    };
    const PoseHistory found = find_pose_drift(history(random, 10, moved), drawn::mount(), {});
    ASSERT_EQ(found.verdict, PoseVerdict::kDrift);
    const PoseChange& change = found.changes.back();
    ramps += change.kind == ChangeKind::kRamp;
    dated += change.first >= 2 && change.first <= 4;
    EXPECT_EQ(change.axis, 4);
  }
  EXPECT_GE(ramps, 90);
  EXPECT_GE(dated, 90);
}

TEST(PoseDrift, TwoStepsAreBothFound) {
  std::mt19937_64 random(4);
  const auto moved = [](int i) {
    Vector6 motion = Vector6::Zero();
    if (i >= 3) motion(0) = 0.01;
    if (i >= 6) motion(5) = 0.05;
    return motion;
  };
  const PoseHistory found = find_pose_drift(history(random, 9, moved), drawn::mount(), {});
  ASSERT_EQ(found.changes.size(), 2U);
  EXPECT_EQ(found.changes[0].first, 3U);
  EXPECT_EQ(found.changes[0].axis, 0);
  EXPECT_EQ(found.changes[1].first, 6U);
  EXPECT_EQ(found.changes[1].axis, 5);
}

TEST(PoseDrift, CovariancesThatAreTooSmallMakeNoDrift) {
  std::mt19937_64 random(5);
  int drifts = 0, inconsistent = 0;
  double squared = 0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    const PoseHistory found = find_pose_drift(history(random, 6, still, 4), drawn::mount(), {});
    drifts += found.verdict == PoseVerdict::kDrift;
    inconsistent += found.verdict == PoseVerdict::kInconsistent;
    const Vector6 error = geometry::log(found.all.T_camera_lidar * drawn::mount().inverse());
    if (found.verdict == PoseVerdict::kInconsistent) {
      squared += error.dot(found.current.covariance.llt().solve(error));
    }
  }
  EXPECT_LE(drifts, 2);
  EXPECT_GE(inconsistent, kTrials - 2);
  EXPECT_LT(squared / inconsistent, 8);  // its covariance has grown with the scatter
}

TEST(PoseDrift, FewCalibrationsSayWhatTheyCan) {
  std::mt19937_64 random(6);
  EXPECT_EQ(find_pose_drift({}, drawn::mount(), {}).verdict, PoseVerdict::kNone);
  EXPECT_FALSE(find_pose_drift({}, drawn::mount(), {}).usable());
  EXPECT_EQ(find_pose_drift(history(random, 1, still), drawn::mount(), {}).verdict,
            PoseVerdict::kSingle);
  const auto moved = [](int i) { return Vector6(0.02 * i * Vector6::Unit(2)); };
  const PoseHistory two = find_pose_drift(history(random, 2, moved), drawn::mount(), {});
  EXPECT_EQ(two.verdict, PoseVerdict::kDrift);
  EXPECT_EQ(two.changes.front().first, 1U);
}

TEST(PoseDrift, DrivesOfOneDateAreNoRamp) {
  std::mt19937_64 random(7);
  auto calibrations =
      history(random, 5, [](int i) { return Vector6(0.01 * (i > 1) * Vector6::Unit(0)); });
  for (auto& calibration : calibrations) calibration.days = 3;
  const PoseHistory found = find_pose_drift(calibrations, drawn::mount(), {});
  ASSERT_EQ(found.verdict, PoseVerdict::kDrift);
  EXPECT_EQ(found.changes.front().kind, ChangeKind::kStep);
}

TEST(PoseDriftOptions, SayWhatIsWrong) {
  EXPECT_FALSE(PoseDriftOptions().invalid());
  EXPECT_TRUE(PoseDriftOptions{.significance = 0}.invalid());
  EXPECT_TRUE(PoseDriftOptions{.max_changes = 0}.invalid());
}

}  // namespace
}  // namespace infuse::calibration

#include "drivers/import/turn_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/recording/sweep_files.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::importers {
namespace {

using recording::Turn;
using Verdict = TurnCheck::Verdict;

// A lidar drives in a slalom among thin poles: a wrong cut shows only while the motion changes.
// Each pole is measured once a turn, at the moment at which the beam points at it.
class TurnCheckTest : public ::testing::Test {
 protected:
  static constexpr double kPeriod = 0.1;

  Eigen::Isometry3d pose(double t) const {
    return Eigen::Translation3d(motion_ * 10 * t, motion_ * std::sin(2 * t), 0) *
           Eigen::AngleAxisd(motion_ * 0.35 * std::sin(3 * t), Eigen::Vector3d::UnitZ());
  }

  // Fraction of a turn at which the beam points at an azimuth.
  static double fraction(const Turn& turn, double azimuth) {
    const double turns = azimuth / (2 * M_PI) - turn.cut_deg / 360;
    const double f = turn.clockwise ? -turns : turns;
    return f - std::floor(f);
  }

  // Verdict about the rule of KITTI, of sweeps that were measured with `truth`.
  TurnCheck check(const Turn& truth) {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> x(-40, 60), y(-30, 30);
    std::vector<Eigen::Vector3d> poles;
    for (int i = 0; i < 400; ++i) poles.emplace_back(x(random), y(random), 0);
    std::vector<StampedFile> files;
    for (size_t k = 0; k < 20; ++k) {
      const double start = static_cast<double>(k) * kPeriod;
      std::vector<Eigen::Vector3d> points;
      for (const Eigen::Vector3d& pole : poles) {
        double t = start + kPeriod / 2;
        Eigen::Vector3d seen;
        for (int step = 0; step < 20; ++step) {
          seen = pose(t).inverse() * pole;
          t = start + kPeriod * fraction(truth, std::atan2(seen.y(), seen.x()));
        }
        for (int i = 0; i < 10; ++i) points.push_back(seen + Eigen::Vector3d(0, 0, 0.25 * i));
      }
      files.push_back(write(k, start, points));
    }
    std::vector<recording::TrajectoryPose> path;
    for (int i = -10; i < 250; ++i) path.push_back({at(0.01 * i), pose(0.01 * i)});
    return check_turn({}, files, path, Eigen::Isometry3d::Identity());
  }

  static Stamp at(double t) { return Stamp::from_ns(1'000'000'000'000) + from_seconds(t); }

  StampedFile write(size_t k, double start, const std::vector<Eigen::Vector3d>& points) {
    Sweep sweep;
    sweep.resize(points.size());
    for (size_t i = 0; i < points.size(); ++i) {
      sweep.x[i] = static_cast<float>(points[i].x());
      sweep.y[i] = static_cast<float>(points[i].y());
      sweep.z[i] = static_cast<float>(points[i].z());
      sweep.reflectivity[i] = 0.5F;
    }
    const auto path = folder_ / (std::to_string(k) + ".bin");
    EXPECT_TRUE(recording::write_sweep_bin(path, sweep));
    return {{.stamp = at(start), .end = at(start + kPeriod)}, path, k};
  }

  ScratchFolder folder_;
  double motion_ = 1;  // 0: the vehicle stands
};

TEST_F(TurnCheckTest, ConfirmsTheRightTurn) {
  const TurnCheck result = check({});
  EXPECT_EQ(result.verdict, Verdict::kConfirmed) << result.reason;
}

TEST_F(TurnCheckTest, RefusesTheOtherDirectionAndAnotherCut) {
  EXPECT_EQ(check({.clockwise = false}).verdict, Verdict::kBlurs);
  EXPECT_EQ(check({.cut_deg = 0}).verdict, Verdict::kBlurs);
  EXPECT_EQ(check({.cut_deg = 90}).verdict, Verdict::kBlurs);
}

TEST_F(TurnCheckTest, CannotTellWhileStanding) {
  motion_ = 0;
  EXPECT_EQ(check({}).verdict, Verdict::kUnknown);
  EXPECT_EQ(check({.clockwise = false}).verdict, Verdict::kUnknown);
}

TEST_F(TurnCheckTest, NeedsTheMotion) {
  EXPECT_EQ(check_turn({}, {}, {}, Eigen::Isometry3d::Identity()).verdict, Verdict::kUnknown);
}

}  // namespace
}  // namespace infuse::importers

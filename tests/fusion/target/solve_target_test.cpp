#include "fusion/target/solve_target.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/fusion/target/synthetic_views.hpp"

namespace infuse::target {
namespace {

using geometry::Matrix6;
using geometry::Vector6;
using synthetic::degrees_between;
using synthetic::metres_between;
using testing::HasSubstr;

const Eigen::Isometry3d kTruth = synthetic::true_T_camera_lidar();

Eigen::Isometry3d initial_guess() { return synthetic::perturb(kTruth, 0.05, 0.1); }

TEST(SolveTarget, TenAndThirtyViewsReachTheStatedAccuracy) {
  constexpr int kRuns = 10;
  for (const int views : {10, 30}) {
    double degrees = 0;
    double metres = 0;
    for (uint64_t seed = 1; seed <= kRuns; ++seed) {
      const TargetResult result =
          solve_target(synthetic::make_views(views, seed), initial_guess(), {});
      ASSERT_TRUE(result.usable()) << result.reason;
      EXPECT_GE(result.used, views - 1);
      degrees += std::pow(degrees_between(result.T_refcam_lidar, kTruth), 2) / kRuns;
      metres += std::pow(metres_between(result.T_refcam_lidar, kTruth), 2) / kRuns;
    }
    EXPECT_LT(std::sqrt(degrees), 0.15) << views;
    EXPECT_LT(std::sqrt(metres), 0.01) << views;
  }
}

/// Ten boards by a lidar whose range biases of all beams, each beam and bright squares are drawn.
std::vector<TargetView> make_biased_views(uint64_t seed) {
  synthetic::RandomSource random(seed);
  const auto errors = synthetic::RangeErrors::draw(0.02, random);
  std::vector<TargetView> views;
  while (views.size() < 10) {
    TargetView view = synthetic::make_view(synthetic::random_board_pose(random, synthetic::board()),
                                           synthetic::board(), random, 0.02, 0.06, errors);
    if (view.returns.size() >= 30) views.push_back(std::move(view));
  }
  return views;
}

TEST(SolveTarget, CovarianceCoversRangeBiasesOfBeamsAndOfBrightSquares) {
  constexpr int kRuns = 40;
  double squares = 0;
  for (uint64_t seed = 1001; seed <= 1000 + kRuns; ++seed) {
    const TargetResult result = solve_target(make_biased_views(seed), initial_guess(), {});
    ASSERT_TRUE(result.usable()) << result.reason;
    const Vector6 error = geometry::log(result.T_refcam_lidar * kTruth.inverse());
    squares += error.dot(result.covariance.inverse() * error) / (6 * kRuns);
  }
  EXPECT_GT(squares, 0.7);  // 240 degrees of freedom: 99.9 % of the mean of a true covariance lies
  EXPECT_LT(squares, 1.4);  // within 0.72 … 1.30
}

TEST(SolveTarget, BoardsThatTiltUnexplainedAreRefused) {
  std::vector<TargetView> views = synthetic::make_views(16, 3);
  synthetic::RandomSource random(4);
  for (TargetView& view : views) {
    Eigen::Isometry3d about = Eigen::Isometry3d::Identity();
    about.translation() = view.T_refcam_board * view.board.middle();
    Vector6 turn = Vector6::Zero();
    for (int k = 0; k < 3; ++k) turn(k) = 0.01 * random.normal();
    view.T_refcam_board = about * geometry::exp(turn) * about.inverse() * view.T_refcam_board;
  }
  const TargetResult result = solve_target(views, initial_guess(), {});
  EXPECT_THAT(result.reason, HasSubstr("more than corners and returns explain"));
  EXPECT_NEAR(result.misfit.tilt, 0.01, 0.004);
}

TEST(SolveTarget, FindsTheTruthWithoutNoise) {
  synthetic::RandomSource random(3);
  std::vector<TargetView> views;
  for (int k = 0; k < 5; ++k) {
    views.push_back(synthetic::make_view(synthetic::random_board_pose(random, synthetic::board()),
                                         synthetic::board(), random, 0, 0));
    views.back().board_covariance.setZero();
  }
  const TargetResult result = solve_target(views, initial_guess(), {});
  EXPECT_LT(degrees_between(result.T_refcam_lidar, kTruth), 1e-3);
  EXPECT_LT(metres_between(result.T_refcam_lidar, kTruth), 1e-4);
}

TEST(SolveTarget, WrongViewsAreRejectedAndListed) {
  std::vector<TargetView> views = synthetic::make_views(12, 7);
  // The board was elsewhere; the returns are on another plane; the board was moved a little.
  views[2].T_refcam_board = synthetic::perturb(views[2].T_refcam_board, 0.4, 0.3);
  for (BoardReturn& seen : views[5].returns) seen.point.x() = 8;
  views[9].T_refcam_board.pretranslate(0.05 * views[9].normal());
  const TargetResult result = solve_target(views, initial_guess(), {});
  EXPECT_TRUE(result.usable()) << result.reason;
  EXPECT_EQ(result.used, 9);
  for (const size_t wrong : {2, 5, 9}) EXPECT_FALSE(result.views[wrong].used) << wrong;
  EXPECT_NEAR(std::abs(result.views[9].offset), 0.05, 0.01);
  EXPECT_LT(degrees_between(result.T_refcam_lidar, kTruth), 0.2);
  EXPECT_LT(metres_between(result.T_refcam_lidar, kTruth), 0.01);
}

/// Views of a board that turns about a single axis.
std::vector<TargetView> make_views_about_axis(const Eigen::Vector3d& axis,
                                              const std::vector<double>& angles) {
  synthetic::RandomSource random(5);
  std::vector<TargetView> views;
  for (const double angle : angles) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    T.translation() = Eigen::Vector3d(random.uniform(-0.5, 0.5), random.uniform(-0.4, 0.4), 3) -
                      T.linear() * synthetic::board().middle();
    views.push_back(synthetic::make_view(T, synthetic::board(), random));
  }
  return views;
}

TEST(SolveTarget, CoplanarNormalsNameTheFreeTranslation) {
  // Turned about the vertical axis of the image: the height of the camera is undetermined.
  const auto upright =
      solve_target(make_views_about_axis(Eigen::Vector3d::UnitY(), {-0.6, -0.3, 0, 0.3, 0.6}),
                   initial_guess(), {});
  EXPECT_FALSE(upright.usable());
  EXPECT_THAT(upright.reason, HasSubstr("all normals lie in one plane"));
  EXPECT_THAT(upright.reason, HasSubstr("1.0"));
  EXPECT_THAT(upright.reason, testing::ContainsRegex("\\(-?0\\.0, 1\\.0, -?0\\.0\\) is free"));
  const Eigen::Vector3d skew = Eigen::Vector3d(0.6, 0.8, 0);
  const auto skewed =
      solve_target(make_views_about_axis(skew, {-0.6, -0.2, 0.2, 0.6}), initial_guess(), {});
  EXPECT_THAT(skewed.reason, testing::ContainsRegex("\\(0\\.6, 0\\.8, -?0\\.0\\) is free"));
}

TEST(SolveTarget, OneOrientationIsNotEnough) {
  const auto result = solve_target(make_views_about_axis(Eigen::Vector3d::UnitX(), {0.3, 0.3, 0.3}),
                                   initial_guess(), {});
  EXPECT_FALSE(result.usable());
  EXPECT_THAT(result.reason, HasSubstr("all normals are parallel"));
  EXPECT_THAT(solve_target({}, initial_guess(), {}).reason, HasSubstr("no usable view"));
}

TEST(SolveTarget, TwoViewsLeaveTheirIntersectionFree) {
  std::vector<TargetView> views = synthetic::make_views(2, 11);
  const Eigen::Vector3d free = views[0].normal().cross(views[1].normal()).normalized();
  const auto result = solve_target(views, initial_guess(), {});
  EXPECT_FALSE(result.usable());
  char text[40];
  const double sign = free.cwiseAbs().maxCoeff() == free.maxCoeff() ? 1 : -1;
  std::snprintf(text, sizeof text, "%.1f", sign * free.y());
  EXPECT_THAT(result.reason, HasSubstr("one plane"));
  EXPECT_THAT(result.reason, HasSubstr(text));
}

TEST(SolveTarget, TooMuchNoiseIsRejected) {
  const auto result =
      solve_target(synthetic::make_views(4, 2, synthetic::board(), 1.0), initial_guess(), {});
  EXPECT_FALSE(result.usable());
}

TEST(SolveTarget, SameSeedSameBytes) {
  const auto views = synthetic::make_views(8, 4);
  const auto a = solve_target(views, initial_guess(), {});
  const auto b = solve_target(views, initial_guess(), {});
  EXPECT_EQ(a.T_refcam_lidar.matrix(), b.T_refcam_lidar.matrix());
  EXPECT_EQ(a.covariance, b.covariance);
}

TEST(SolveTargetOptions, ReportsInvalidValues) {
  EXPECT_FALSE(SolveTargetOptions{}.invalid());
  EXPECT_THAT(*(SolveTargetOptions{.errors = {.range_accuracy = 0}}.invalid()),
              HasSubstr("range_accuracy"));
  EXPECT_THAT(*(SolveTargetOptions{.max_mahalanobis = -1}.invalid()), HasSubstr("max_mahalanobis"));
  EXPECT_THAT(*(SolveTargetOptions{.max_translation_sigma = 0}.invalid()), HasSubstr("sigma"));
}

TEST(ReturnsPlane, FourPointsHaveTheReturnsMeanAndSpreadInThePlane) {
  const TargetView view = synthetic::make_views(1, 9)[0];
  const ReturnsPlane plane = fit_returns_plane(view.returns);
  Eigen::Matrix3d all = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d four = Eigen::Matrix3d::Zero();
  const auto square = [&](const Eigen::Vector3d& point) -> Eigen::Matrix3d {
    const Eigen::Vector3d out = point - plane.mean;
    const Eigen::Vector3d flat = out - plane.normal.dot(out) * plane.normal;
    return flat * flat.transpose();
  };
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& [point, ring, reflectivity] : view.returns) {
    const auto n = static_cast<double>(view.returns.size());
    mean += point / n;
    all += square(point) / n;
  }
  for (int k = 0; k < 4; ++k) four += square(plane.points.col(k)) / 4;
  EXPECT_LT((all - four).norm(), 1e-9);
  EXPECT_LT((mean - plane.points.rowwise().mean()).norm(), 1e-9);
  EXPECT_LT(plane.normal.dot(plane.mean), 0);
}

}  // namespace
}  // namespace infuse::target

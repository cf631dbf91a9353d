#include "fusion/target/calibrate_intrinsics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <string>

#include "tests/fusion/target/synthetic_views.hpp"

namespace infuse::target {
namespace {

using synthetic::RandomSource;
using testing::HasSubstr;

constexpr Board kHandBoard{.columns = 9, .rows = 6, .square_size = 0.025};

CameraIntrinsics webcam() {
  return {.width = 1280,
          .height = 720,
          .fx = 905,
          .fy = 908,
          .cx = 652,
          .cy = 349,
          .distortion = {-0.12, 0.09, 0.0008, -0.0011, -0.02}};
}

CameraIntrinsics fisheye() {
  return {.model = CameraIntrinsics::Model::kFisheye,
          .width = 1280,
          .height = 960,
          .fx = 380,
          .fy = 381,
          .cx = 630,
          .cy = 489,
          .distortion = {-0.02, 0.008, -0.005, 0.0008}};
}

/// Ranges that views are drawn from.
struct ViewRanges {
  double min_tilt = 0.2, max_tilt = 0.8;  // rad
  double off_axis = 0.4;                  // rad, of the board's middle
  double near = 0.25, far = 0.5;          // m
};

ViewRanges wide_ranges() { return {.off_axis = 1.1, .near = 0.12, .far = 0.3}; }

/// A view of the board, completely in the image.
Corners draw_view(const CameraIntrinsics& intrinsics, const ViewRanges& ranges, double noise,
                  double bow, RandomSource& random) {
  const geometry::CameraModel camera(intrinsics);
  while (true) {
    const Eigen::AngleAxisd aside(
        random.uniform(0, ranges.off_axis),
        Eigen::AngleAxisd(random.uniform(0, 2 * M_PI), Eigen::Vector3d::UnitZ()) *
            Eigen::Vector3d::UnitX());
    const Eigen::AngleAxisd tilt(
        random.uniform(ranges.min_tilt, ranges.max_tilt),
        Eigen::AngleAxisd(random.uniform(0, 2 * M_PI), Eigen::Vector3d::UnitZ()) *
            Eigen::Vector3d::UnitX());
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    const Eigen::AngleAxisd roll(random.uniform(-0.4, 0.4), Eigen::Vector3d::UnitZ());
    T.linear() = (tilt * roll).toRotationMatrix();
    // A fisheye's board is held towards the camera.
    if (ranges.off_axis > 1) T.linear() = aside.toRotationMatrix() * T.linear();
    T.translation() = aside * Eigen::Vector3d(0, 0, random.uniform(ranges.near, ranges.far)) -
                      T.linear() * kHandBoard.middle();
    Corners corners;
    for (size_t i = 0; i < kHandBoard.corner_count(); ++i) {
      Eigen::Vector3d corner = kHandBoard.corner(i);
      const double along = (corner.x() - kHandBoard.middle().x()) / kHandBoard.half_size().x();
      corner.z() += bow * along * along;
      const auto pixel = camera.project(T * corner);
      if (!pixel || !camera.in_image(*pixel)) break;
      corners.push_back(*pixel + noise * Eigen::Vector2d(random.normal(), random.normal()));
    }
    if (corners.size() == kHandBoard.corner_count()) return corners;
  }
}

std::vector<Corners> draw_views(const CameraIntrinsics& intrinsics, const ViewRanges& ranges,
                                size_t count, double noise, RandomSource& random) {
  std::vector<Corners> views;
  while (views.size() < count) views.push_back(draw_view(intrinsics, ranges, noise, 0, random));
  return views;
}

/// The model and size of a camera, as a caller knows them.
CameraIntrinsics unknown(const CameraIntrinsics& camera) {
  return {.model = camera.model, .width = camera.width, .height = camera.height};
}

/// M²: squared Mahalanobis distance of a result from the truth.
double squared_distance(const IntrinsicsResult& result, const CameraIntrinsics& truth) {
  const Eigen::Index count = result.covariance.rows();
  const Eigen::VectorXd error = (to_vector(result.camera) - to_vector(truth)).head(count);
  return error.dot(result.covariance.inverse() * error);
}

/// Mean of M² / n over seeds. Each view's noise is drawn, as where a hand holds the board.
double mean_distance(const CameraIntrinsics& truth, const ViewRanges& ranges, uint64_t seeds) {
  double sum = 0;
  for (uint64_t seed = 1; seed <= seeds; ++seed) {
    RandomSource random(seed);
    std::vector<Corners> views;
    const double bow = 0.001 * random.normal();
    while (views.size() < 15) {
      views.push_back(draw_view(truth, ranges, 0.1 * std::exp(0.3 * random.normal()), bow, random));
    }
    const IntrinsicsResult result = calibrate_intrinsics(unknown(truth), kHandBoard, views, {});
    EXPECT_TRUE(result.usable()) << seed << ": " << result.reason;
    if (!result.usable()) return -1;
    sum += squared_distance(result, truth) / static_cast<double>(result.covariance.rows());
  }
  return sum / static_cast<double>(seeds);
}

TEST(CalibrateIntrinsics, SigmaOfAPinholeHolds) {
  const double mean = mean_distance(webcam(), {}, 40);
  RecordProperty("mean", std::to_string(mean));
  EXPECT_GT(mean, 0.7);
  EXPECT_LT(mean, 1.4);
}

TEST(CalibrateIntrinsics, SigmaOfAFisheyeHolds) {
  const double mean = mean_distance(fisheye(), wide_ranges(), 40);
  RecordProperty("mean", std::to_string(mean));
  EXPECT_GT(mean, 0.7);
  EXPECT_LT(mean, 1.4);
}

TEST(CalibrateIntrinsics, ParallelBoardsAreRefused) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    RandomSource random(seed);
    const auto views =
        draw_views(webcam(), {.min_tilt = 0, .max_tilt = 0.02, .off_axis = 0.3}, 20, 0.1, random);
    const IntrinsicsResult result = calibrate_intrinsics(unknown(webcam()), kHandBoard, views, {});
    EXPECT_FALSE(result.usable());
    EXPECT_THAT(result.reason, HasSubstr("focal length"));
    EXPECT_THAT(result.reason, HasSubstr("of parallel"));
  }
}

TEST(CalibrateIntrinsics, AViewOfAnotherBoardIsNamedAndLeftOut) {
  RandomSource random(3);
  auto views = draw_views(webcam(), {}, 15, 0.1, random);
  for (size_t i = 0; i < views[4].size(); ++i) views[4][i].x() += i % 9 == 3 ? 4 : 0;
  const IntrinsicsResult result = calibrate_intrinsics(unknown(webcam()), kHandBoard, views, {});
  EXPECT_TRUE(result.usable()) << result.reason;
  EXPECT_FALSE(result.views[4].used);
  EXPECT_GE(result.used, 13U);
  EXPECT_LT(squared_distance(result, webcam()), 21.7);  // 99 % of χ² with 9 degrees of freedom
}

TEST(CalibrateIntrinsics, AFisheyeIsNoPinhole) {
  RandomSource random(4);
  const auto views = draw_views(fisheye(), wide_ranges(), 20, 0.1, random);
  CameraIntrinsics pinhole = unknown(fisheye());
  pinhole.model = CameraIntrinsics::Model::kPinhole;
  const IntrinsicsResult result = calibrate_intrinsics(pinhole, kHandBoard, views, {});
  EXPECT_FALSE(result.usable());
}

TEST(CalibrateIntrinsics, RandomCornersAndFewViewsAreRefused) {
  RandomSource random(5);
  std::vector<Corners> views(12);
  for (Corners& corners : views) {
    while (corners.size() < kHandBoard.corner_count())
      corners.emplace_back(random.uniform(0, 1279), random.uniform(0, 719));
  }
  EXPECT_FALSE(calibrate_intrinsics(unknown(webcam()), kHandBoard, views, {}).usable());
  views.resize(7);
  EXPECT_THAT(calibrate_intrinsics(unknown(webcam()), kHandBoard, views, {}).reason,
              HasSubstr("7 views"));
  EXPECT_FALSE(calibrate_intrinsics(unknown(webcam()), kHandBoard, {}, {}).usable());
}

}  // namespace
}  // namespace infuse::target

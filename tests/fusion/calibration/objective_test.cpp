#include "fusion/calibration/objective.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace infuse::calibration {
namespace {

using geometry::Vector6;

CameraIntrinsics pinhole() {
  return {.width = 200, .height = 150, .fx = 130, .fy = 125, .cx = 98, .cy = 77};
}

CameraIntrinsics distorted() {
  CameraIntrinsics out = pinhole();
  out.distortion = {-0.2, 0.05, 0.002, -0.003, 0.01};
  return out;
}

CameraIntrinsics fisheye() {
  CameraIntrinsics out = pinhole();
  out.model = CameraIntrinsics::Model::kFisheye;
  out.distortion = {0.02, -0.01, 0.003, 0, 0};
  return out;
}

/// Smooth image and points scattered in front of it, whose features follow the image.
Scene smooth_scene(size_t camera, uint64_t seed) {
  Scene scene;
  scene.camera = camera;
  for (const ImageFeature feature : {ImageFeature::kLocalGrey, ImageFeature::kEdge}) {
    features::Plane& plane = scene.image[index(feature)];
    plane.width = 200;
    plane.height = 150;
    const double phase = feature == ImageFeature::kLocalGrey ? 0.3 : 1.4;
    for (int v = 0; v < plane.height; ++v) {
      for (int u = 0; u < plane.width; ++u) {
        plane.values.push_back(static_cast<float>(0.5 + 0.4 * std::sin(0.05 * u + phase) *
                                                            std::cos(0.06 * v - phase)));
      }
    }
  }
  std::mt19937_64 random(seed);
  const auto draw = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  for (int i = 0; i < 3000; ++i) {
    const double depth = draw(4, 20);
    const double a = draw(-0.6, 0.6);
    const double b = draw(-0.5, 0.45);
    scene.x.push_back(static_cast<float>(a * depth));
    scene.y.push_back(static_cast<float>(b * depth));
    scene.z.push_back(static_cast<float>(depth));
    const double seen = 0.5 + 0.3 * std::sin(6.5 * a + 5.2) * std::cos(7.5 * b + 4.3);
    scene.lidar[index(LidarFeature::kRelativeReflectivity)].push_back(
        static_cast<float>(seen + draw(0, 0.1)));
    scene.lidar[index(LidarFeature::kDiscontinuity)].push_back(
        static_cast<float>(seen * seen + draw(0, 0.2)));
  }
  return scene;
}

struct Rig {
  std::vector<RigCamera> cameras;
  std::vector<Scene> scenes;
  std::vector<TermOptions> terms;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
};

Rig make_rig(const std::vector<CameraIntrinsics>& intrinsics,
             const std::vector<TermOptions>& terms) {
  Rig rig{.terms = terms};
  for (size_t c = 0; c < intrinsics.size(); ++c) {
    Vector6 mount;
    mount << 0.03, -0.02, 0.05, 0.4, -0.3, 0.2;
    rig.cameras.push_back(
        {geometry::CameraModel(intrinsics[c]), geometry::exp(static_cast<double>(c) * mount)});
    rig.scenes.push_back(smooth_scene(c, c + 1));
  }
  Vector6 xi;
  xi << 0.02, 0.01, -0.03, 0.05, -0.1, 0.08;
  rig.T = geometry::exp(xi);
  return rig;
}

/// Compares the analytic gradient with central differences; the points are those in view at
/// `rig.T`.
void expect_gradient_matches(const Rig& rig, double tolerance) {
  const VisiblePoints points = select_visible(rig.scenes, rig.cameras, rig.T, {.occlusion = {}});
  const BlurredImages images(rig.scenes, rig.cameras, rig.terms, ImageBlur::in_angle(2));
  Objective objective(points, images, rig.cameras, rig.scenes, rig.terms);
  const Evaluation at = objective.evaluate(rig.T, true);
  ASSERT_TRUE(at.estimate.usable()) << at.estimate.reason;
  Vector6 numeric;
  for (int k = 0; k < 6; ++k) {
    const double step = k < 3 ? 1e-3 : 1e-2;
    const Vector6 xi = step * Vector6::Unit(k);
    numeric(k) = (objective.evaluate(geometry::exp(xi) * rig.T, false).estimate.value -
                  objective.evaluate(geometry::exp(-xi) * rig.T, false).estimate.value) /
                 (2 * step);
  }
  ASSERT_GT(numeric.head<3>().norm(), 1e-3);
  EXPECT_LT((at.gradient - numeric).head<3>().norm(), tolerance * numeric.head<3>().norm())
      << at.gradient.transpose() << "\n"
      << numeric.transpose();
  EXPECT_LT((at.gradient - numeric).tail<3>().norm(), tolerance * numeric.tail<3>().norm())
      << at.gradient.transpose() << "\n"
      << numeric.transpose();
}

class EveryMeasure : public testing::TestWithParam<size_t> {};

TEST_P(EveryMeasure, GradientMatchesDifferences) {
  for (const bool equalize : {false, true}) {
    expect_gradient_matches(
        make_rig({pinhole()}, {{.measure = dependence::kMeasureNames[GetParam()].measure,
                                .equalize = equalize}}),
        0.03);
  }
}

INSTANTIATE_TEST_SUITE_P(Objective, EveryMeasure,
                         testing::Range(size_t{0}, std::size(dependence::kMeasureNames)));

const std::vector<TermOptions> kTwoTerms{
    {}, {.lidar = {LidarFeature::kDiscontinuity}, .image = {ImageFeature::kEdge}, .weight = 2}};

TEST(Objective, GradientOfSeveralFeaturesTogether) {
  for (const Estimator estimator : {Estimator::kLsmi, Estimator::kBlsmi}) {
    expect_gradient_matches(
        make_rig({pinhole()},
                 {{.measure = Measure::kSquaredLossMutualInformation,
                   .estimator = estimator,
                   .lidar = {LidarFeature::kRelativeReflectivity, LidarFeature::kDiscontinuity},
                   .image = {ImageFeature::kLocalGrey, ImageFeature::kEdge},
                   .equalize = false,
                   .bags = 3}}),
        0.03);
  }
}

TEST(Objective, GradientOfASumOfTerms) {
  expect_gradient_matches(make_rig({pinhole()}, kTwoTerms), 0.03);
}
TEST(Objective, GradientThroughDistortion) {
  expect_gradient_matches(make_rig({distorted()}, kTwoTerms), 0.03);
}
TEST(Objective, GradientThroughAFisheye) {
  expect_gradient_matches(make_rig({fisheye()}, kTwoTerms), 0.03);
}
TEST(Objective, GradientOfARigOfThreeCameras) {
  expect_gradient_matches(make_rig({pinhole(), distorted(), fisheye()}, kTwoTerms), 0.03);
}

TEST(Objective, ScenesAddUpToTheWhole) {
  const Rig rig = make_rig({pinhole(), distorted(), fisheye()}, kTwoTerms);
  const VisiblePoints points = select_visible(rig.scenes, rig.cameras, rig.T, {});
  const BlurredImages images(rig.scenes, rig.cameras, rig.terms, ImageBlur::in_angle(2));
  Objective objective(points, images, rig.cameras, rig.scenes, rig.terms);
  const Vector6 whole = objective.evaluate(rig.T, true).gradient;
  Vector6 sum = Vector6::Zero();
  for (const SceneGradient& part : objective.scene_gradients(rig.T)) sum += part.head<6>();
  EXPECT_LT((whole - sum).norm(), 1e-9 * whole.norm());
}

/// Changes one of a camera's four intrinsics by a step.
RigCamera with_intrinsic_offset(const RigCamera& camera, int which, double step) {
  CameraIntrinsics model = camera.model.intrinsics();
  model.fx *= which == 0 ? std::exp(step) : 1;
  model.fy *= which == 0 ? std::exp(step) : 1;
  model.cx += which == 1 ? step : 0;
  model.cy += which == 2 ? step : 0;
  model.distortion[0] += which == 3 ? step : 0;
  return {geometry::CameraModel(model), camera.T_camera_refcam};
}

TEST(Objective, IntrinsicGradientsMatchDifferences) {
  for (const CameraIntrinsics& model : {pinhole(), distorted(), fisheye()}) {
    const Rig rig = make_rig({model}, kTwoTerms);
    const VisiblePoints points = select_visible(rig.scenes, rig.cameras, rig.T, {});
    const BlurredImages images(rig.scenes, rig.cameras, rig.terms, ImageBlur::in_angle(2));
    Objective objective(points, images, rig.cameras, rig.scenes, rig.terms);
    Eigen::Vector4d pull = Eigen::Vector4d::Zero();
    dependence::Estimate whole;
    for (const SceneGradient& part : objective.scene_gradients(rig.T, &whole))
      pull += part.tail<4>();
    EXPECT_EQ(whole.value, objective.evaluate(rig.T, false).estimate.value);
    const double steps[] = {1e-3, 0.1, 0.1, 3e-3};
    for (int which = 0; which < 4; ++which) {
      double values[2];
      for (const int side : {0, 1}) {
        const std::vector<RigCamera> other{
            with_intrinsic_offset(rig.cameras[0], which, (2 * side - 1) * steps[which])};
        objective.set_cameras(other);
        values[side] = objective.evaluate(rig.T, false).estimate.value;
      }
      objective.set_cameras(rig.cameras);
      const double expected = (values[1] - values[0]) / (2 * steps[which]);
      EXPECT_NEAR(pull(which), expected, 0.05 * std::abs(expected) + 1e-4) << which;
    }
  }
}

TEST(Objective, PointsThatLeaveTheImageKeepTheBorderValue) {
  const Rig rig = make_rig({pinhole()}, {{}});
  const VisiblePoints points = select_visible(rig.scenes, rig.cameras, rig.T, {});
  const BlurredImages images(rig.scenes, rig.cameras, rig.terms, ImageBlur::in_angle(2));
  Objective objective(points, images, rig.cameras, rig.scenes, rig.terms);
  // Rotated by 60°, all points lie beyond one border: they all have values of its column.
  const Eigen::Isometry3d away = geometry::exp(1.05 * Vector6::Unit(1)) * rig.T;
  const Evaluation there = objective.evaluate(away, true);
  EXPECT_EQ(objective.point_count(), points.size());
  EXPECT_LT(there.estimate.value, objective.evaluate(rig.T, false).estimate.value);
  EXPECT_TRUE(there.gradient.allFinite());
}

TEST(Objective, PointsThatAreNotComparedHaveNoEffect) {
  // The samples are the same with and without such points.
  Rig rig = make_rig({pinhole()}, kTwoTerms);
  Scene& scene = rig.scenes.front();
  std::vector<float>& edge = scene.lidar[index(LidarFeature::kDiscontinuity)];
  for (size_t i = 0; i < edge.size(); i += 3) edge[i] = features::kNotCompared;
  Rig few = rig;
  Scene& thin = few.scenes.front();
  size_t n = 0;
  for (size_t i = 0; i < edge.size(); ++i) {
    if (i % 3 == 0) continue;
    for (auto* from : {&thin.x, &thin.y, &thin.z, &thin.lidar[index(LidarFeature::kDiscontinuity)],
                       &thin.lidar[index(LidarFeature::kRelativeReflectivity)]}) {
      (*from)[n] = (*from)[i];
    }
    ++n;
  }
  for (auto* all : {&thin.x, &thin.y, &thin.z, &thin.lidar[index(LidarFeature::kDiscontinuity)],
                    &thin.lidar[index(LidarFeature::kRelativeReflectivity)]}) {
    all->resize(n);
  }
  const std::vector<TermOptions> edges{kTwoTerms.back()};
  const VisibilityOptions all_of_them{.occlusion = {}};
  const BlurredImages images(rig.scenes, rig.cameras, edges, ImageBlur::in_angle(2));
  const VisiblePoints with_intrinsic_offset =
      select_visible(rig.scenes, rig.cameras, rig.T, all_of_them);
  const VisiblePoints without = select_visible(few.scenes, few.cameras, few.T, all_of_them);
  ASSERT_GT(with_intrinsic_offset.size(), without.size());
  Objective a(with_intrinsic_offset, images, rig.cameras, rig.scenes, edges);
  Objective b(without, images, few.cameras, few.scenes, edges);
  const Evaluation of_a = a.evaluate(rig.T, true);
  const Evaluation of_b = b.evaluate(few.T, true);
  EXPECT_NEAR(of_a.estimate.value, of_b.estimate.value, 1e-9);
  EXPECT_LT((of_a.gradient - of_b.gradient).norm(), 1e-6 * of_b.gradient.norm());
  const SceneInformation information = b.information(few.T).scenes.front();
  EXPECT_LT((a.information(rig.T).scenes.front() - information).norm(), 1e-6 * information.norm());
  EXPECT_EQ(a.samples(rig.T, 0).image, b.samples(few.T, 0).image);
}

TEST(Objective, NoPointsAreReported) {
  Rig rig = make_rig({pinhole()}, {{}});
  const VisiblePoints none;
  const BlurredImages images(rig.scenes, rig.cameras, rig.terms, ImageBlur::in_angle(2));
  Objective objective(none, images, rig.cameras, rig.scenes, rig.terms);
  EXPECT_FALSE(objective.evaluate(rig.T, true).estimate.usable());
}

}  // namespace
}  // namespace infuse::calibration

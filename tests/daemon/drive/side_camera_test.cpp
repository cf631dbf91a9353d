// A camera that faces sideways, towards trees and facades. Rings do not cross kerbs, eaves and the
// horizon, and depth steps are larger in tree crowns than at trunks. Depth edges compared with all
// image edges, or ranked over all rings, converge one degree and 20 cm off there.

#include <gtest/gtest.h>

#include "daemon/tools/calibrate/calibration_run.hpp"
#include "drivers/measurement/angles.hpp"
#include "fusion/geometry/extrinsic_error.hpp"
#include "tests/daemon/drive/simulated.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kScenario = R"(
duration_s = 21
[world]
map = "altfeld.osm"
route = [100, 104, 112]
[light]
sun = 0.3
[vehicle]
speed = 8
start_speed = 8
[[lidar]]
model = "HDL-64E S2"
position = [1.0, 0.0, 2.1]
turn_stride = 10
rays_per_pulse = 1
[[camera]]
width = 640
height = 480
fx = 336
position = [0.6185, 0.0571, 1.85]
rotation_deg = [0.0, 0.0, 72]
distortion = [-0.2, 0.04, 0.0, 0.0, 0.0]
rate_hz = 1
phase_s = 0.05
format = "jpg"
)";

ScenePairs simulated_pairs() {
  const TemporaryFolder folder;
  const auto made = simulate(folder / "drive", kScenario);
  EXPECT_TRUE(made) << made.error().message();
  auto pairs =
      read_scene_pairs({.drives = {(folder / "drive").string()}, .max_scenes = 21}, [](double) {});
  EXPECT_TRUE(pairs && pairs->truth);
  return *std::move(pairs);
}

/// Calibrates from an initial guess that is 0.5° and 3 cm off.
CalibrationRun calibrate_perturbed(const ScenePairs& pairs,
                                   const calibration::NamedMeasure& measure) {
  std::mt19937_64 random(1);
  const Eigen::Isometry3d initial_pose = perturb(*pairs.truth, 0.5 * kDegree, 0.03, random);
  return *run_calibration(pairs, measure, initial_pose, {});
}

geometry::ExtrinsicError error_of(const CalibrationRun& calibrate_perturbed,
                                  const ScenePairs& pairs) {
  return geometry::extrinsic_error(calibrate_perturbed.result.T_refcam_lidar, *pairs.truth,
                                   calibrate_perturbed.cameras.front().model);
}

TEST(SideCamera, DepthEdgesConverge) {
  const ScenePairs pairs = simulated_pairs();
  const auto edges =
      error_of(calibrate_perturbed(pairs, *calibration::find_measure("edges")), pairs);
  EXPECT_LT(edges.rotation, 0.2 * kDegree);
  EXPECT_LT(edges.translation, 0.08);

  const CalibrationRun both = calibrate_perturbed(pairs, *calibration::find_measure("joint"));
  EXPECT_LT(error_of(both, pairs).rotation, 0.15 * kDegree);
  EXPECT_LT(error_of(both, pairs).translation, 0.03);
}

}  // namespace
}  // namespace infuse::daemon

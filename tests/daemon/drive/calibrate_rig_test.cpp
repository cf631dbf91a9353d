// Calibration of a simulated rig, as `infuse calibrate` does it: two cameras together;
// wrong inputs are reported and never give a usable result.

#include <gtest/gtest.h>

#include <algorithm>

#include "daemon/tools/calibrate/calibration_run.hpp"
#include "drivers/measurement/angles.hpp"
#include "fusion/geometry/extrinsic_error.hpp"
#include "tests/daemon/drive/simulated.hpp"

namespace infuse::daemon {
namespace {

void make_drive(const std::filesystem::path& folder) {
  const std::string camera =
      "[[camera]]\n"
      "width = 640\n"
      "height = 480\n"
      "fx = 420\n"
      "rate_hz = 1\n"
      "phase_s = 0.05\n"
      "format = \"jpg\"\n";
  const std::string text =
      "duration_s = 12\n"
      "[world]\n"
      "map = \"altfeld.osm\"\n"
      "route = [100, 104, 112, 110]\n"
      "[light]\n"
      "sun = 0.3\n"
      "[vehicle]\n"
      "speed = 9\n"
      "start_speed = 9\n"
      "[[lidar]]\n"
      "model = \"HDL-64E S2\"\n"
      "position = [1.0, 0.0, 1.95]\n"
      "rays_per_pulse = 1\n" +
      camera + "name = \"front\"\nposition = [1.5, 0.05, 1.6]\nrotation_deg = [0.4, 2.0, -0.6]\n" +
      camera + "name = \"left\"\nposition = [1.4, 0.4, 1.6]\nrotation_deg = [0.0, 2.0, 60.0]\n";
  const auto made = simulate(folder, text);
  ASSERT_TRUE(made) << made.error().message();
}

CalibrationRun calibrate(const ScenePairs& pairs, const Eigen::Isometry3d& initial_pose) {
  auto run = run_calibration(pairs, calibration::named_measures().front(), initial_pose, {});
  EXPECT_TRUE(run) << run.error().message();
  return *run;
}

TEST(CalibrateRig, TwoCamerasConvergeAndWrongInputsAreNotUsable) {
  const TemporaryFolder folder;
  ASSERT_NO_FATAL_FAILURE(make_drive(folder / "drive"));
  auto read = read_scene_pairs(
      {.drives = {(folder / "drive").string()}, .cameras = {"front", "left"}}, [](double) {});
  ASSERT_TRUE(read) << read.error().message();
  ASSERT_TRUE(read->truth);
  ASSERT_EQ(read->cameras.size(), 2U);
  EXPECT_EQ(camera_names(*read), "front and left");
  // The first images precede the first speed estimate.
  std::erase_if(read->pairs, [](const ScenePair& pair) { return !pair.deskew_reason.empty(); });
  const auto of_left = std::count_if(read->pairs.begin(), read->pairs.end(),
                                     [](const ScenePair& pair) { return pair.camera == 1; });
  EXPECT_GE(of_left, 9);
  std::mt19937_64 random(1);
  const Eigen::Isometry3d initial_pose = perturb(*read->truth, kDegree, 0.05, random);

  const CalibrationRun right = calibrate(*read, initial_pose);
  EXPECT_TRUE(right.result.usable()) << right.result.reason;
  const auto error = geometry::extrinsic_error(right.result.T_refcam_lidar, *read->truth,
                                               right.cameras.front().model);
  EXPECT_LT(error.rotation, 0.2 * kDegree);
  EXPECT_LT(error.translation, 0.03);

  ScenePairs longer = *read;
  for (CameraMount& camera : longer.cameras) {
    camera.intrinsics.fx *= 1.08;
    camera.intrinsics.fy *= 1.08;
  }
  EXPECT_FALSE(calibrate(longer, initial_pose).result.usable()) << "focal lengths 8 % too long";

  ScenePairs other = *read;
  for (size_t k = 0; k < other.pairs.size(); ++k) {
    const ScenePair& next = read->pairs[(k + 1) % read->pairs.size()];
    if (next.camera == other.pairs[k].camera) other.pairs[k].frame = next.frame;
  }
  EXPECT_FALSE(calibrate(other, initial_pose).result.usable()) << "images one second late";

  ScenePairs blind = *read;
  for (ScenePair& pair : blind.pairs) {
    std::fill(pair.frame.pixels.begin(), pair.frame.pixels.end(), uint8_t{90});
  }
  EXPECT_FALSE(calibrate(blind, initial_pose).result.usable()) << "images without content";
}

}  // namespace
}  // namespace infuse::daemon

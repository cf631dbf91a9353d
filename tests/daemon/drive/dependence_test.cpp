// The mutual information of ten simulated scans and their images peaks at the camera's true pose
// along each of the six axes, under an overcast sky and in the sun. Shadows, which the lidar does
// not see, lower it.

#include <gtest/gtest.h>

#include "daemon/playback/calibration_scenes.hpp"
#include "fusion/calibration/coarse_to_fine.hpp"
#include "fusion/calibration/image_pyramid.hpp"
#include "fusion/calibration/named_measures.hpp"
#include "tests/daemon/drive/simulated.hpp"

namespace infuse::daemon {
namespace {

void make_drive_in_sun(const std::filesystem::path& folder, double sun) {
  const std::string text =
      "duration_s = 11\n"
      "[world]\n"
      "map = \"altfeld.osm\"\n"
      "route = [100, 104, 112, 110]\n"
      "[light]\n"
      "sun = " +
      std::to_string(sun) +
      "\n"
      "sun_elevation_deg = 32\n"
      "[vehicle]\n"
      "speed = 9\n"
      "start_speed = 9\n"
      "[[lidar]]\n"
      "model = \"HDL-64E S2\"\n"
      "position = [1.0, 0.0, 1.95]\n"
      "turn_stride = 10\n"
      "rays_per_pulse = 1\n"
      "[[camera]]\n"
      "width = 800\n"
      "height = 600\n"
      "fx = 500\n"
      "position = [1.5, 0.05, 1.6]\n"
      "rotation_deg = [0.4, 2.0, -0.6]\n"
      "rate_hz = 1\n"
      "phase_s = 0.05\n"
      "format = \"jpg\"\n";
  const auto made = simulate(folder, text);
  ASSERT_TRUE(made) << made.error().message();
}

/// Returns the measure at the truth and checks that it is smaller everywhere else on the axes.
double check_peak(const std::filesystem::path& folder) {
  const auto pairs =
      read_scene_pairs({.drives = {folder.string()}, .max_scenes = 11}, [](double) {});
  if (!pairs || !pairs->truth) {
    ADD_FAILURE() << "no pairs or no truth";
    return 0;
  }
  std::vector<calibration::Scene> scenes;
  for (const ScenePair& pair : pairs->pairs) {
    if (!pair.deskew_reason.empty()) continue;  // the first: no odometry yet
    scenes.push_back(*calibration::make_scene(pair.sweep, pair.frame, {}));
  }
  EXPECT_EQ(scenes.size(), 10U);
  const std::vector<calibration::RigCamera> cameras{
      {geometry::CameraModel(pairs->cameras.front().intrinsics)}};
  const std::vector<calibration::TermOptions> terms = calibration::find_measure("mi")->terms;
  const calibration::VisiblePoints points =
      calibration::select_visible(scenes, cameras, *pairs->truth, {});
  const calibration::BlurredImages images(scenes, cameras, terms,
                                          calibration::ImageBlur::in_angle(1.5));
  calibration::Objective measure(points, images, cameras, scenes, terms);
  const double at_truth = measure.evaluate(*pairs->truth, false).estimate.value;
  for (int axis = 0; axis < 6; ++axis) {
    const double step = axis < 3 ? 2.5e-3 : 0.04;
    for (const double steps : {-8.0, -4.0, -2.0, -1.0, 1.0, 2.0, 4.0, 8.0}) {
      const Eigen::Isometry3d wrong =
          geometry::exp(steps * step * geometry::Vector6::Unit(axis)) * *pairs->truth;
      EXPECT_LT(measure.evaluate(wrong, false).estimate.value, at_truth)
          << "axis " << axis << ", " << steps << " steps";
    }
  }
  return at_truth;
}

TEST(Dependence, PeaksAtTheTruthAlongEveryAxisUnderAnEvenSkyAndInTheSun) {
  const TemporaryFolder folder;
  ASSERT_NO_FATAL_FAILURE(make_drive_in_sun(folder / "overcast", 0));
  ASSERT_NO_FATAL_FAILURE(make_drive_in_sun(folder / "sun", 1));
  const double overcast = check_peak(folder / "overcast");
  const double sun = check_peak(folder / "sun");
  EXPECT_GT(sun, 0);
  EXPECT_LT(sun, overcast);
}

}  // namespace
}  // namespace infuse::daemon

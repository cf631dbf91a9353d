#include "tests/study/rigs/far_study.hpp"

#include <ctime>
#include <numbers>
#include <random>

#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/any_heading.hpp"
#include "fusion/geometry/draw_uniform.hpp"
#include "tests/study/rigs/rig_study.hpp"

namespace infuse::study {
namespace {

constexpr double kTen = 10 * kDegree;
constexpr double kNear = 0.08, kFarther = 0.3;  // m

/// T with the lidar turned by `angle` about its z axis, the camera staying where it is.
Eigen::Isometry3d turned(const Eigen::Isometry3d& T_camera_lidar, double angle) {
  const Eigen::Vector3d centre = T_camera_lidar.inverse().translation();
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = T_camera_lidar.linear() *
               Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T.translation() = -T.linear() * centre;
  return T;
}

}  // namespace

void start_far(const RigRecording& recording, uint64_t seed, FarStart start, std::ostream& out,
               FarCounts& counts) {
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return geometry::draw_uniform(random); };
  const bool any = start == FarStart::kAnyHeading;
  geometry::Vector6 off;
  for (int k = 0; k < 6; ++k) off(k) = uniform() * (k < 3 ? kTen : any ? kFarther : kNear);
  const double heading = any ? std::numbers::pi * uniform() : 0;
  const Eigen::Isometry3d initial = geometry::exp(off) * turned(recording.T_camera_lidar, heading);
  const calibration::RigCamera camera{geometry::CameraModel(recording.camera)};
  const auto scenes = make_scenes(recording.diverse, camera, initial);
  calibration::CalibrateOptions options{.seed = seed};
  options.screen.half_width = kTen;
  const std::clock_t began = std::clock();
  const auto result =
      any ? calibration::calibrate_any_heading(scenes, std::span(&camera, 1), initial, options)
          : calibration::calibrate(scenes, std::span(&camera, 1), initial, options);
  const double cpu = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
  const RigTrial trial = judge(result, recording.T_camera_lidar);
  ++counts.trials;
  counts.right += trial.right() ? 1 : 0;
  counts.usable += trial.usable ? 1 : 0;
  counts.surely_wrong += trial.surely_wrong() ? 1 : 0;
  out << seed << ',' << recording.lidar << ',' << recording.camera.width << ',' << heading / kDegree
      << ',' << trial.right() << ',' << trial.usable << ',' << trial.rotation_error / kDegree << ','
      << 100 * trial.translation_error << ',' << trial.mahalanobis_squared << ',' << cpu << ",\""
      << trial.reason << "\"\n";
}

}  // namespace infuse::study

#include "tests/study/rigs/far_study.hpp"

#include <ctime>
#include <numbers>
#include <random>

#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/any_heading.hpp"
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
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0; };
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
  const geometry::Vector6 error =
      geometry::log(recording.T_camera_lidar * result.T_refcam_lidar.inverse());
  const double metres = (recording.T_camera_lidar.inverse().translation() -
                         result.T_refcam_lidar.inverse().translation())
                            .norm();
  const bool converged = error.head<3>().norm() < 0.5 * kDegree && metres < 0.1;
  ++counts.trials;
  counts.converged += converged ? 1 : 0;
  counts.usable += result.usable() ? 1 : 0;
  counts.wrong += result.usable() && !converged ? 1 : 0;
  out << seed << ',' << recording.lidar << ',' << recording.camera.width << ',' << heading / kDegree
      << ',' << converged << ',' << result.usable() << ',' << error.head<3>().norm() / kDegree
      << ',' << 100 * metres << ',' << cpu << ",\"" << result.reason << "\"\n";
}

}  // namespace infuse::study

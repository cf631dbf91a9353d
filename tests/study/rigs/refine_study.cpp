#include "tests/study/rigs/refine_study.hpp"

#include <cmath>
#include <ctime>
#include <random>
#include <span>

#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/refine_intrinsics.hpp"
#include "fusion/geometry/draw_uniform.hpp"
#include "tests/study/rigs/rig_study.hpp"

namespace infuse::study {
namespace {

constexpr double kChiSquareOfFour95 = 9.488;  // 95 % of 4 degrees of freedom

}  // namespace

void refine_on(const RigRecording& recording, uint64_t seed, std::ostream& out,
               RefineCounts& counts) {
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return geometry::draw_uniform(random); };
  const CameraIntrinsics& truth = recording.camera;
  CameraIntrinsics stated = truth;
  const double factor = 1 + 0.02 * uniform();
  stated.fx *= factor;
  stated.fy *= factor;
  stated.cx += 8 * uniform();
  stated.cy += 8 * uniform();
  stated.distortion[0] += 0.03 * uniform();
  geometry::Vector6 off;
  for (int k = 0; k < 6; ++k) off(k) = uniform() * (k < 3 ? 2 * kDegree : 0.08);
  const Eigen::Isometry3d initial = geometry::exp(off) * recording.T_camera_lidar;
  const calibration::RigCamera camera{geometry::CameraModel(stated)};
  const std::clock_t began = std::clock();
  const auto found =
      calibration::calibrate_with_intrinsics(make_scenes(recording.diverse, camera, initial),
                                             std::span(&camera, 1), initial, {.seed = seed});
  const double cpu = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
  const calibration::RefinedIntrinsics& refined = found.cameras.front();
  const Eigen::Vector4d error(std::log(refined.intrinsics.fx / truth.fx),
                              refined.intrinsics.cx - truth.cx, refined.intrinsics.cy - truth.cy,
                              refined.intrinsics.distortion[0] - truth.distortion[0]);
  const geometry::Vector6 apart =
      geometry::log(recording.T_camera_lidar * found.result.T_refcam_lidar.inverse());
  const Eigen::Vector4d sigma = refined.covariance.diagonal().cwiseSqrt();
  ++counts.trials;
  out << seed << ',' << recording.lidar << ',' << truth.width << ',' << found.refined << ','
      << found.result.usable() << ',' << 100 * error(0) << ',' << error(1) << ',' << error(2) << ','
      << error(3) << ',' << 100 * sigma(0) << ',' << sigma(1) << ',' << sigma(2) << ',' << sigma(3)
      << ',' << apart.head<3>().norm() / kDegree << ',' << 100 * apart.tail<3>().norm() << ','
      << cpu << ",\"" << found.result.reason << "\"\n";
  if (!found.refined) return;
  ++counts.refined;
  counts.usable += found.result.usable() ? 1 : 0;
  counts.within +=
      std::abs(error(0)) < 0.005 && error.segment<2>(1).norm() < 2 && std::abs(error(3)) < 0.01;
  counts.inside += error.dot(refined.covariance.ldlt().solve(error)) < kChiSquareOfFour95;
}

}  // namespace infuse::study

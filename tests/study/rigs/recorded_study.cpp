#include "tests/study/rigs/recorded_study.hpp"

#include <cmath>
#include <vector>

#include "daemon/playback/calibration_scenes.hpp"
#include "daemon/tools/calibrate/calibration_run.hpp"
#include "drivers/measurement/angles.hpp"

namespace infuse::study {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

/// A calibration of some images, and its difference from the stated pose.
struct Part {
  std::string name;
  Vector6 difference = Vector6::Zero();
  Matrix6 covariance = Matrix6::Identity();  // of what differs from drive to drive
};

void write_axes(std::ostream& out, const Vector6& values) {
  for (int k = 0; k < 6; ++k) {
    const double shown = k < 3 ? values(k) / kDegree : 100 * values(k);
    out << ' ' << std::round(1000 * shown) / 1000;
  }
}

Part calibrate_part(std::ostream& out, const std::string& name, const daemon::ScenePairs& pairs,
                    std::vector<calibration::Scene> scenes) {
  const Eigen::Isometry3d stated =
      pairs.truth ? *pairs.truth : pairs.cameras.front().T_camera_lidar;
  const size_t images = scenes.size();
  const daemon::CalibrationRun run =
      daemon::run_calibration(pairs, std::move(scenes), calibration::named_measures().front(),
                              stated, {}, daemon::CalibrationKind::kPose);
  const calibration::CalibrationResult& result = run.result;
  Part part{.name = name,
            .difference = geometry::log(stated * result.T_refcam_lidar.inverse()),
            .covariance = result.uncertainty.covariance + run.motion.covariance};
  out << name << ", " << images << " images, count as " << result.uncertainty.effective_scenes
      << (result.usable() ? "" : ", not usable: " + result.reason) << "\n  from the stated pose:";
  write_axes(out, part.difference);
  out << "\n  standard deviation:  ";
  write_axes(out, part.covariance.diagonal().cwiseSqrt());
  out << '\n' << std::flush;
  return part;
}

void compare_parts(std::ostream& out, const Part& a, const Part& b) {
  const Vector6 apart = a.difference - b.difference;
  const Matrix6 covariance = a.covariance + b.covariance;
  out << a.name << " against " << b.name << ":";
  write_axes(out, apart);
  out << ", M2/6 " << apart.dot(covariance.inverse() * apart) / 6 << '\n' << std::flush;
}

Result<daemon::ScenePairs> read_all(const std::string& drive) {
  return daemon::read_scene_pairs({.drives = {drive}, .max_scenes = 1000}, [](double) {});
}

Result<std::vector<calibration::Scene>> scenes_of(const daemon::ScenePairs& pairs) {
  return daemon::make_scenes(pairs, calibration::named_measures().front(),
                             pairs.truth ? *pairs.truth : pairs.cameras.front().T_camera_lidar);
}

}  // namespace

Result<void> study_recorded(std::ostream& out, const std::string& drive, const std::string& other) {
  const auto pairs = read_all(drive);
  if (!pairs) return tl::unexpected(pairs.error());
  const auto scenes = scenes_of(*pairs);
  if (!scenes) return tl::unexpected(scenes.error());
  const auto half = static_cast<std::ptrdiff_t>(scenes->size() / 2);
  std::vector<calibration::Scene> even, odd;
  for (size_t s = 0; s < scenes->size(); ++s) (s % 2 == 0 ? even : odd).push_back((*scenes)[s]);
  const Part first =
      calibrate_part(out, "first half", *pairs, {scenes->begin(), scenes->begin() + half});
  const Part second =
      calibrate_part(out, "second half", *pairs, {scenes->begin() + half, scenes->end()});
  compare_parts(out, first, second);
  const Part evens = calibrate_part(out, "even images", *pairs, even);
  compare_parts(out, evens, calibrate_part(out, "odd images", *pairs, odd));
  const Part all = calibrate_part(out, "all", *pairs, *scenes);
  if (other.empty()) return {};
  const auto other_pairs = read_all(other);
  if (!other_pairs) return tl::unexpected(other_pairs.error());
  auto other_scenes = scenes_of(*other_pairs);
  if (!other_scenes) return tl::unexpected(other_scenes.error());
  compare_parts(out, all,
                calibrate_part(out, "other drive", *other_pairs, std::move(*other_scenes)));
  return {};
}

}  // namespace infuse::study

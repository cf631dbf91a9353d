#include "tests/study/rigs/compare_study.hpp"

#include <random>
#include <sstream>

#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/compact_scene.hpp"
#include "fusion/calibration/compare_extrinsics.hpp"
#include "fusion/calibration/named_measures.hpp"
#include "fusion/calibration/objective.hpp"
#include "fusion/geometry/draw_uniform.hpp"
#include "tests/study/rigs/rig_study.hpp"

namespace infuse::study {
namespace {

constexpr int kDraws = 2;
constexpr int kEqualDraws = 4;
constexpr double kEqualDegrees = 0.1;
constexpr double kMargin = 3 * kDegree;  // more than any pose is turned

/// Rotation by `degrees` about an axis drawn evenly.
Eigen::Isometry3d draw_turn(double degrees, std::mt19937_64& random) {
  Eigen::Vector3d axis;
  do {
    for (int k = 0; k < 3; ++k) axis(k) = geometry::draw_uniform(random);
  } while (axis.norm() > 1 || axis.norm() < 0.1);
  return Eigen::Isometry3d(Eigen::AngleAxisd(degrees * kDegree, axis.normalized()));
}

}  // namespace

void compare_on(const RigRecording& recording, uint64_t seed, CompareCounts& counts) {
  const std::vector<calibration::RigCamera> cameras{{geometry::CameraModel(recording.camera)}};
  const Eigen::Isometry3d& truth = recording.T_camera_lidar;
  std::vector<calibration::Scene> scenes = make_scenes(recording.diverse, cameras.front(), truth);
  const calibration::CompactOptions compact{
      .image = calibration::compared_image_features(calibration::named_measures().front().terms),
      .blurs = {calibration::ImageBlur::in_angle(calibration::CompareOptions{}.sigma)},
      .margin = kMargin};
  for (calibration::Scene& scene : scenes) {
    calibration::compact_scene(scene, cameras.front(), truth, compact);
  }
  std::mt19937_64 random(seed);
  const auto compare_poses = [&](const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                                 CompareCounts::Count& count) {
    ++count.trials;
    for (size_t k = 0; k < CompareCounts::kBiases.size(); ++k) {
      const auto compared = calibration::compare_extrinsics(
          scenes, cameras, a, b, {.bias = CompareCounts::kBiases[k], .seed = seed});
      counts.unusable += compared.usable() ? 0 : 1;
      if (!compared.usable() || compared.p_value >= 0.05) continue;
      ++(compared.better > 0 ? count.named_right : count.named_wrong)[k];
    }
  };
  for (size_t k = 0; k < counts.worse.size(); ++k) {
    for (int draw = 0; draw < kDraws; ++draw) {
      compare_poses(draw_turn(CompareCounts::kDegreesWorse[k], random) * truth, truth,
                    counts.worse[k]);
    }
  }
  for (int draw = 0; draw < kEqualDraws; ++draw) {
    const Eigen::Isometry3d turn = draw_turn(kEqualDegrees, random);
    compare_poses(turn * truth, turn.inverse() * truth, counts.equal);
  }
}

std::string CompareCounts::text() const {
  std::ostringstream out;
  out << "| compared with the truth | trials | bias, px | right one named | wrong one named "
         "|\n|---|---|---|---|---|\n";
  const auto write_rows = [&](const std::string& name, const Count& count) {
    for (size_t k = 0; k < kBiases.size(); ++k) {
      out << "| " << name << " | " << count.trials << " | " << kBiases[k] << " | "
          << count.named_right[k] << " | " << count.named_wrong[k] << " |\n";
    }
  };
  for (size_t k = 0; k < worse.size(); ++k) {
    std::ostringstream name;
    name << "turned by " << kDegreesWorse[k] << " degrees";
    write_rows(name.str(), worse[k]);
  }
  write_rows("equally far to opposite sides: one of them", equal);
  out << "\nnothing could be said: " << unusable << '\n';
  return out.str();
}

}  // namespace infuse::study

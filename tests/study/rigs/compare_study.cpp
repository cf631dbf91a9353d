#include "tests/study/rigs/compare_study.hpp"

#include <random>
#include <sstream>

#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/compare_extrinsics.hpp"
#include "tests/study/rigs/rig_study.hpp"

namespace infuse::study {
namespace {

constexpr int kDraws = 2;
constexpr int kEqualDraws = 5;
constexpr double kEqualDegrees = 0.1;

/// Rotation by `degrees` about an axis drawn evenly.
Eigen::Isometry3d draw_turn(double degrees, std::mt19937_64& random) {
  Eigen::Vector3d axis;
  do {
    for (int k = 0; k < 3; ++k) axis(k) = static_cast<double>(random() >> 11) * 0x1p-52 - 1.0;
  } while (axis.norm() > 1 || axis.norm() < 0.1);
  return Eigen::Isometry3d(Eigen::AngleAxisd(degrees * kDegree, axis.normalized()));
}

}  // namespace

void compare_on(const RigRecording& recording, uint64_t seed, CompareCounts& counts) {
  const std::vector<calibration::RigCamera> cameras{{geometry::CameraModel(recording.camera)}};
  const Eigen::Isometry3d& truth = recording.T_camera_lidar;
  const std::vector<calibration::Scene> scenes =
      make_scenes(recording.diverse, cameras.front(), truth);
  std::mt19937_64 random(seed);
  // Positive: b is better by more than chance.
  const auto compare_poses = [&](const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    const auto compared = calibration::compare_extrinsics(scenes, cameras, a, b, {.seed = seed});
    counts.unusable += compared.usable() ? 0 : 1;
    return compared.usable() && compared.p_value < 0.05 ? compared.better : 0.0;
  };
  for (size_t k = 0; k < counts.worse.size(); ++k) {
    for (int draw = 0; draw < kDraws; ++draw) {
      const double better =
          compare_poses(draw_turn(CompareCounts::kDegreesWorse[k], random) * truth, truth);
      ++counts.worse[k].trials;
      counts.worse[k].named_right += better > 0 ? 1 : 0;
      counts.worse[k].named_wrong += better < 0 ? 1 : 0;
    }
  }
  for (int draw = 0; draw < kEqualDraws; ++draw) {
    const Eigen::Isometry3d turn = draw_turn(kEqualDegrees, random);
    ++counts.equal_trials;
    counts.equal_named += compare_poses(turn * truth, turn.inverse() * truth) != 0 ? 1 : 0;
  }
}

std::string CompareCounts::text() const {
  std::ostringstream out;
  out << "| compared with the truth | trials | right one named | wrong one named "
         "|\n|---|---|---|---|\n";
  for (size_t k = 0; k < worse.size(); ++k) {
    out << "| turned by " << kDegreesWorse[k] << " degrees | " << worse[k].trials << " | "
        << worse[k].named_right << " | " << worse[k].named_wrong << " |\n";
  }
  out << "\nequally far to opposite sides: one of them named " << equal_named << " of "
      << equal_trials << "; nothing could be said: " << unusable << '\n';
  return out.str();
}

}  // namespace infuse::study

#pragma once

#include <array>
#include <optional>
#include <vector>

#include "daemon/playback/calibration_scenes.hpp"
#include "daemon/tools/calibrate/calibration_run.hpp"

namespace infuse::daemon {

/// What the pairs of a calibration are prepared for.
struct PreparationOptions {
  std::vector<const calibration::NamedMeasure*> measures;
  calibration::CalibrateOptions calibrate;
  CalibrationKind kind = CalibrationKind::kPose;
  Eigen::Isometry3d T_refcam_lidar = Eigen::Isometry3d::Identity();  ///< initial pose
  /// Extrinsics to compare with on the pairs that `hold_out` takes.
  std::optional<Eigen::Isometry3d> T_old;
  bool draw = false;  ///< few images and sweeps stay, to be drawn
};

/// Makes the scenes of pairs as they are read, and releases images and sweeps: what a calibration
/// keeps of a pair is a small part of it.
class ScenePreparation {
 public:
  explicit ScenePreparation(PreparationOptions options) : options_(std::move(options)) {}

  /// Makes `pair.scenes`, one per measure, or one for `compare_on` of a pair that is held out.
  /// Errors: a pair from which no scene can be made.
  Result<void> prepare(ScenePairs& pairs, ScenePair& pair);

 private:
  /// Pairs whose data stays, spread evenly over those that were prepared.
  struct Drawn {
    std::vector<size_t> pairs;
    size_t seen = 0, stride = 1;
  };

  void release(ScenePairs& pairs, ScenePair& pair, Drawn& drawn) const;

  PreparationOptions options_;
  std::vector<size_t> of_camera_;  // number of pairs of each camera so far
  std::array<Drawn, 2> drawn_;     // of pairs to calibrate with, and held out
};

/// Takes the prepared scenes of one measure out of the pairs.
std::vector<calibration::Scene> move_scenes(ScenePairs& pairs, size_t measure);

}  // namespace infuse::daemon

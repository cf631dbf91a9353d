#include "daemon/tools/calibrate/scene_preparation.hpp"

#include <cmath>

#include "daemon/tools/calibrate/calibration_comparison.hpp"
#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/compact_scene.hpp"
#include "fusion/calibration/compare_extrinsics.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxDrawn = 6;               // pairs whose image and sweep stay
constexpr double kWiderMargin = 2 * kDegree;  // what is drawn around a result

/// By how much the camera may come to be rotated from the initial pose; nothing: in any way.
std::optional<double> rotation_margin(const PreparationOptions& options) {
  const double screened = options.calibrate.screen.half_width * std::sqrt(3.0);
  switch (options.kind) {
    case CalibrationKind::kPose:
      return screened + kWiderMargin;
    case CalibrationKind::kIntrinsics:
      return 2 * screened + kWiderMargin;  // again from the result
    case CalibrationKind::kDelay:          // the points move
    case CalibrationKind::kAnyHeading:
      break;
  }
  return std::nullopt;
}

/// Image features that a measure compares.
calibration::PerImageFeature<bool> compared_by(const calibration::NamedMeasure& measure) {
  auto compared = calibration::compared_image_features(measure.terms);
  const auto searched = calibration::compared_image_features(measure.search_terms);
  for (size_t f = 0; f < compared.size(); ++f) compared[f] = compared[f] || searched[f];
  return compared;
}

}  // namespace

void ScenePreparation::release(ScenePairs& pairs, ScenePair& pair, Drawn& drawn) const {
  if (!options_.draw || drawn.seen++ % drawn.stride != 0) {
    pair.release();
    return;
  }
  drawn.pairs.push_back(pairs.pairs.size());
  if (drawn.pairs.size() <= kMaxDrawn) return;
  std::vector<size_t> kept;
  for (size_t k = 0; k < drawn.pairs.size(); ++k) {
    if (k % 2 == 0) {
      kept.push_back(drawn.pairs[k]);
    } else {
      (drawn.pairs[k] < pairs.pairs.size() ? pairs.pairs[drawn.pairs[k]] : pair).release();
    }
  }
  drawn.pairs = std::move(kept);
  drawn.stride *= 2;
}

Result<void> ScenePreparation::prepare(ScenePairs& pairs, ScenePair& pair) {
  of_camera_.resize(pairs.cameras.size(), 0);
  const bool held_out = options_.T_old && is_held_out(of_camera_[pair.camera]++);
  const calibration::RigCamera camera = rig_camera(pairs, pair.camera);
  const Eigen::Isometry3d& T = held_out ? *options_.T_old : options_.T_refcam_lidar;
  const std::vector<const calibration::NamedMeasure*> compared{
      &calibration::named_measures().front()};
  for (const calibration::NamedMeasure* measure : held_out ? compared : options_.measures) {
    auto scene = make_scene(pairs, pair, *measure, T);
    if (!scene) return tl::unexpected(scene.error());
    calibration::CompactOptions compact{.image = compared_by(*measure), .blurs = {}, .margin = {}};
    if (held_out) {
      compact.blurs = {calibration::ImageBlur::in_angle(calibration::CompareOptions{}.sigma)};
    } else {
      compact.blurs = calibration::image_blurs(options_.calibrate);
      compact.margin = rotation_margin(options_);
    }
    calibration::compact_scene(*scene, camera, T, compact);
    pair.scenes.push_back(std::move(*scene));
  }
  release(pairs, pair, drawn_[held_out ? 1 : 0]);
  return {};
}

std::vector<calibration::Scene> move_scenes(ScenePairs& pairs, size_t measure) {
  std::vector<calibration::Scene> scenes;
  for (ScenePair& pair : pairs.pairs) scenes.push_back(std::move(pair.scenes[measure]));
  return scenes;
}

}  // namespace infuse::daemon

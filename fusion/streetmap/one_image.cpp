#include "fusion/streetmap/one_image.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/streetmap/image_score.hpp"

namespace infuse::streetmap {
namespace {

constexpr size_t kFewestPixels = 100;

bool is_boundary(SegmentKind kind) {
  return kind == SegmentKind::kKerb || kind == SegmentKind::kWall ||
         kind == SegmentKind::kImageLine;
}

}  // namespace

const char* name(ImageMeasure measure) {
  switch (measure) {
    case ImageMeasure::kLsmi:
      return "LSMI";
    case ImageMeasure::kBlsmi:
      return "BLSMI";
    case ImageMeasure::kMi:
      return "MLMI";
    case ImageMeasure::kQmi:
      return "LSQMI";
    case ImageMeasure::kSce:
      return "LSCE";
    case ImageMeasure::kCorrelation:
      return "dCor";
    case ImageMeasure::kBoundaries:
      return "boundaries";
  }
  return "";
}

std::optional<std::string> OneImageOptions::invalid() const {
  if (auto wrong = fit.invalid()) return wrong;
  if (!(across >= 0 && across_step > 0 && across / across_step <= 500)) {
    return "one image: across must be 0 … 500 steps, across_step positive";
  }
  if (!(turn >= 0 && turn_step > 0 && turn / turn_step <= 500)) {
    return "one image: turn must be 0 … 500 steps, turn_step positive";
  }
  if (!(nearest >= 0 && nearest < farthest && farthest <= 1000)) {
    return "one image: 0 ≤ nearest < farthest ≤ 1000 m is needed";
  }
  if (most_samples < 100 || most_samples > 100'000) {
    return "one image: most_samples must be 100 … 100000";
  }
  if (bags < 1 || bags * 50 > most_samples) return "one image: a bag needs 50 samples";
  return std::nullopt;
}

OneImagePose locate_by_picture(const SegmentMap& map, const PictureFeatures& features,
                               const geometry::CameraModel& camera,
                               const Eigen::Isometry3d& T_camera_vehicle, const PlanarPose& prior,
                               const OneImageOptions& options) {
  OneImagePose result;
  if (!map.covers(prior.x, prior.y)) {
    result.reason = "the prior pose is outside the map";
    return result;
  }
  const GroundPixels pixels = ground_pixels(features, camera, T_camera_vehicle, options);
  if (pixels.size() < kFewestPixels) {
    result.reason = "too few pixels see the ground";
    return result;
  }
  LabelWindow window;
  window.read(map, prior.x, prior.y, options.farthest + options.across + 1, options.labelling);
  std::vector<bool> boundary(static_cast<size_t>(window.label_count()));
  for (int label = 0; label < window.label_count(); ++label) {
    boundary[static_cast<size_t>(label)] = is_boundary(window.kind(label));
  }
  const LabelScore score = label_score(pixels, options, boundary);
  if (!score) {
    result.reason = "the picture says nothing of the ground";
    return result;
  }
  std::vector<int32_t> labels(pixels.size());
  const auto score_at = [&](double across, double yaw) {
    window.look_up(prior.then({0, across, yaw}), pixels.x, pixels.y, labels);
    return score(labels, window.label_count());
  };
  score_at(0, 0);  // hyper-parameters are chosen at the prior
  const int turns = static_cast<int>(std::floor(options.turn / options.turn_step + 1e-9));
  const int sides = static_cast<int>(std::floor(options.across / options.across_step + 1e-9));
  bool first = true;
  for (int t = -turns; t <= turns; ++t) {
    for (int s = -sides; s <= sides; ++s) {
      const double across = s * options.across_step, yaw = t * options.turn_step;
      result.scores.push_back(score_at(across, yaw));
      if (!first && result.scores.back() <= result.score) continue;
      first = false;
      result.score = result.scores.back();
      result.across = across;
      result.yaw = yaw;
    }
  }
  return result;
}

}  // namespace infuse::streetmap

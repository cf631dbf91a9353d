#include "tests/study/streetmap/single_image_pose.hpp"

#include <algorithm>
#include <cmath>

#include "tests/study/streetmap/image_score.hpp"

namespace infuse::streetmap {
namespace {

constexpr size_t kMinPixels = 100;

bool is_boundary(SegmentKind kind) {
  return kind == SegmentKind::kKerb || kind == SegmentKind::kWall ||
         kind == SegmentKind::kImageLine;
}

}  // namespace

const char* name_of(ImageMeasure measure) {
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

std::optional<std::string> SingleImageOptions::invalid() const {
  if (auto wrong = fit.invalid()) return wrong;
  if (!(max_lateral >= 0 && lateral_step > 0 && max_lateral / lateral_step <= 500)) {
    return "single image: max_lateral must be between 0 and 500 steps, lateral_step positive";
  }
  if (!(max_yaw >= 0 && yaw_step > 0 && max_yaw / yaw_step <= 500)) {
    return "single image: max_yaw must be between 0 and 500 steps, yaw_step positive";
  }
  if (!(min_distance >= 0 && min_distance < max_distance && max_distance <= 1000)) {
    return "single image: 0 ≤ min_distance < max_distance ≤ 1000 m is needed";
  }
  if (max_samples < 100 || max_samples > 100'000) {
    return "single image: max_samples must be between 100 and 100000";
  }
  if (bag_count < 1 || bag_count * 50 > max_samples) return "single image: a bag needs 50 samples";
  return std::nullopt;
}

SingleImagePose locate_from_image(const SegmentMap& map, const ImageFeatures& features,
                                  const geometry::CameraModel& camera,
                                  const Eigen::Isometry3d& T_camera_vehicle,
                                  const PlanarPose& prior, const SingleImageOptions& options) {
  SingleImagePose result;
  if (!map.covers(prior.x, prior.y)) {
    result.reason = "the prior pose is outside the map";
    return result;
  }
  const GroundPixels pixels = find_ground_pixels(features, camera, T_camera_vehicle, options);
  if (pixels.size() < kMinPixels) {
    result.reason = "too few pixels show the ground";
    return result;
  }
  LabelWindow window;
  window.read(map, prior.x, prior.y, options.max_distance + options.max_lateral + 1,
              options.labelling);
  std::vector<bool> boundary(static_cast<size_t>(window.label_count()));
  for (int label = 0; label < window.label_count(); ++label) {
    boundary[static_cast<size_t>(label)] = is_boundary(window.kind(label));
  }
  const LabelScore score = make_label_score(pixels, options, boundary);
  if (!score) {
    result.reason = "the image of the ground has no texture";
    return result;
  }
  std::vector<int32_t> labels(pixels.size());
  const auto score_at = [&](double across, double yaw) {
    window.look_up(prior.compose({0, across, yaw}), pixels.x, pixels.y, labels);
    return score(labels, window.label_count());
  };
  score_at(0, 0);  // hyper-parameters are chosen at the prior
  const int turns = static_cast<int>(std::floor(options.max_yaw / options.yaw_step + 1e-9));
  const int sides = static_cast<int>(std::floor(options.max_lateral / options.lateral_step + 1e-9));
  bool first = true;
  for (int t = -turns; t <= turns; ++t) {
    for (int s = -sides; s <= sides; ++s) {
      const double across = s * options.lateral_step, yaw = t * options.yaw_step;
      result.scores.push_back(score_at(across, yaw));
      if (!first && result.scores.back() <= result.score) continue;
      first = false;
      result.score = result.scores.back();
      result.lateral = across;
      result.yaw = yaw;
    }
  }
  return result;
}

}  // namespace infuse::streetmap

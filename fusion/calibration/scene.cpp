#include "fusion/calibration/scene.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fusion/features/image_edges.hpp"
#include "fusion/features/ranks.hpp"
#include "fusion/features/relative_reflectivity.hpp"

namespace infuse::calibration {
namespace {

using features::Plane;

Plane equalized(Plane plane) {
  features::equalize_by_level(plane.values, 256);
  return plane;
}

Plane scaled(Plane plane, float factor) {
  for (float& value : plane.values) value *= factor;
  return plane;
}

/// Returns one channel of a kBgr8 frame (grey frames have three equal ones), 0 … 1.
Plane colour_plane(const CameraFrame& frame, size_t channel) {
  Plane plane{.width = frame.width, .height = frame.height, .values = {}};
  const auto step = static_cast<size_t>(channels(frame.format));
  plane.values.resize(static_cast<size_t>(frame.width) * static_cast<size_t>(frame.height));
  for (size_t i = 0; i < plane.values.size(); ++i) {
    plane.values[i] =
        static_cast<float>(frame.pixels[step * i + (step == 3 ? channel : 0)]) / 255.0F;
  }
  return plane;
}

/// True if a wanted feature compares the returns of one ring.
bool needs_rings(const SceneOptions& options) {
  using enum LidarFeature;
  const auto wanted = {kRelativeReflectivity, kDiscontinuity, kRelativeDiscontinuity};
  return std::any_of(wanted.begin(), wanted.end(),
                     [&](LidarFeature feature) { return options.lidar[index(feature)]; });
}

/// Computes the wanted features of all returns; the other arrays stay empty.
PerLidarFeature<std::vector<float>> compute_lidar_features(const Sweep& sweep,
                                                           const SceneOptions& options) {
  using enum LidarFeature;
  const auto wanted = [&](LidarFeature feature) { return options.lidar[index(feature)]; };
  PerLidarFeature<std::vector<float>> lidar;
  const auto at = [&](LidarFeature feature) -> auto& { return lidar[index(feature)]; };
  if (wanted(kReflectivity)) {
    at(kReflectivity).assign(sweep.reflectivity.begin(), sweep.reflectivity.end());
  }
  if (wanted(kRelativeReflectivity)) {
    features::RelativeReflectivity ranks;
    at(kRelativeReflectivity) = ranks.compute(sweep.ring, sweep.range, sweep.reflectivity);
  }
  if (wanted(kDiscontinuity) || wanted(kRelativeDiscontinuity)) {
    std::vector<float> edges =
        features::Discontinuity(options.discontinuity).compute(features::make_sweep_view(sweep));
    if (wanted(kRelativeDiscontinuity)) {
      at(kRelativeDiscontinuity) = features::relative_discontinuity(sweep.ring, edges);
    }
    if (wanted(kDiscontinuity)) at(kDiscontinuity) = std::move(edges);
  }
  if (wanted(kNormalX) || wanted(kNormalY) || wanted(kNormalZ)) {
    auto normals = surface_normals(sweep, options.normals);
    at(kNormalX) = std::move(normals[0]);
    at(kNormalY) = std::move(normals[1]);
    at(kNormalZ) = std::move(normals[2]);
  }
  return lidar;
}

}  // namespace

std::optional<std::string> SceneOptions::invalid() const {
  if (auto wrong = discontinuity.invalid()) return "discontinuity: " + *wrong;
  if (auto wrong = normals.invalid()) return "normals: " + *wrong;
  if (!(min_range >= 0) || !(max_range > min_range)) return "0 <= min_range < max_range must hold";
  return std::nullopt;
}

PerImageFeature<features::Plane> compute_image_features(const CameraFrame& frame,
                                                        const SceneOptions& options) {
  const auto shown = [&](ImageFeature feature) { return options.image[index(feature)]; };
  PerImageFeature<Plane> image;
  Plane grey = features::grey_plane(frame);
  const auto finish = [&](Plane plane) {
    return options.equalize ? equalized(std::move(plane)) : scaled(std::move(plane), 1.0F / 255.0F);
  };
  if (shown(ImageFeature::kRingEdge)) {
    image[index(ImageFeature::kRingEdge)] = finish(features::ring_edge(grey, options.rings));
  }
  if (shown(ImageFeature::kEdge))
    image[index(ImageFeature::kEdge)] = finish(features::edge_strength(grey));
  if (shown(ImageFeature::kGrey)) image[index(ImageFeature::kGrey)] = finish(grey);
  if (shown(ImageFeature::kLocalGrey)) {
    image[index(ImageFeature::kLocalGrey)] = scaled(std::move(grey), 1.0F / 255.0F);
  }
  constexpr std::pair<ImageFeature, size_t> kColours[] = {
      {ImageFeature::kBlue, 0}, {ImageFeature::kGreen, 1}, {ImageFeature::kRed, 2}};
  for (const auto& [feature, channel] : kColours) {
    if (shown(feature)) image[index(feature)] = colour_plane(frame, channel);
  }
  return image;
}

Result<Scene> make_scene(const Sweep& sweep, const CameraFrame& frame,
                         const SceneOptions& options) {
  if (frame.format != PixelFormat::kGrey8 && frame.format != PixelFormat::kBgr8) {
    return fail("a Bayer mosaic has no features", {}, "interpolate it to grey or colour first");
  }
  if (frame.width < 3 || frame.height < 3 ||
      frame.pixels.size() != frame.row_bytes() * static_cast<size_t>(frame.height)) {
    return fail("the image is empty or truncated");
  }

  if (sweep.rings == 0 && sweep.size() > 0 && needs_rings(options)) {
    return fail(
        "the rings of the sweep are not known", {},
        "write its points with a field 'ring', or all of one turn in the lidar's own frame");
  }

  Scene scene;
  const PerLidarFeature<std::vector<float>> lidar = compute_lidar_features(sweep, options);
  for (size_t i = 0; i < sweep.size(); ++i) {
    if (!(sweep.range[i] >= options.min_range && sweep.range[i] <= options.max_range)) continue;
    scene.x.push_back(sweep.x[i]);
    scene.y.push_back(sweep.y[i]);
    scene.z.push_back(sweep.z[i]);
    for (size_t f = 0; f < kLidarFeatures; ++f) {
      if (!lidar[f].empty()) scene.lidar[f].push_back(lidar[f][i]);
    }
  }
  if (scene.size() == 0) return fail("the sweep has no return between min_range and max_range");

  scene.image = compute_image_features(frame, options);
  return scene;
}

}  // namespace infuse::calibration

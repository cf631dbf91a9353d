#include "fusion/calibration/scene.hpp"

#include <cmath>
#include <utility>

#include "fusion/calibration/relative_reflectivity.hpp"

namespace infuse::calibration {
namespace {

Plane scaled(Plane plane, float factor) {
  for (float& value : plane.values) value *= factor;
  return plane;
}

/// One channel of a kBgr8 frame (grey frames have three equal ones), 0 … 1.
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

}  // namespace

std::optional<std::string> SceneOptions::invalid() const {
  if (auto wrong = discontinuity.invalid()) return "discontinuity: " + *wrong;
  if (!(min_range >= 0) || !(max_range > min_range)) return "0 <= min_range < max_range must hold";
  return std::nullopt;
}

PerImageFeature<Plane> picture_features(const CameraFrame& frame,
                                        const PerImageFeature<bool>& wanted, bool equalize) {
  const auto shown = [&](ImageFeature feature) { return wanted[index(feature)]; };
  PerImageFeature<Plane> image;
  const Plane grey = grey_plane(frame);
  if (shown(ImageFeature::kLocalGrey)) {
    image[index(ImageFeature::kLocalGrey)] = scaled(grey, 1.0F / 255.0F);
  }
  const auto finish = [&](Plane plane) {
    return equalize ? equalized(std::move(plane)) : scaled(std::move(plane), 1.0F / 255.0F);
  };
  if (shown(ImageFeature::kEdge)) image[index(ImageFeature::kEdge)] = finish(edge_strength(grey));
  if (shown(ImageFeature::kGrey)) image[index(ImageFeature::kGrey)] = finish(grey);
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
    return fail("the picture is empty");
  }
  const auto wanted = [&](LidarFeature feature) { return options.lidar[index(feature)]; };

  Scene scene;
  std::vector<float> edge;
  if (wanted(LidarFeature::kDiscontinuity)) edge = discontinuity(sweep, options.discontinuity);
  RelativeReflectivity ranks;
  std::span<const float> relative;
  if (wanted(LidarFeature::kRelativeReflectivity)) {
    relative = ranks.of(sweep.ring, sweep.range, sweep.reflectivity);
  }
  for (size_t i = 0; i < sweep.size(); ++i) {
    if (!(sweep.range[i] >= options.min_range && sweep.range[i] <= options.max_range)) continue;
    scene.x.push_back(sweep.x[i]);
    scene.y.push_back(sweep.y[i]);
    scene.z.push_back(sweep.z[i]);
    if (wanted(LidarFeature::kReflectivity)) {
      scene.lidar[index(LidarFeature::kReflectivity)].push_back(sweep.reflectivity[i]);
    }
    if (!relative.empty()) {
      scene.lidar[index(LidarFeature::kRelativeReflectivity)].push_back(relative[i]);
    }
    if (!edge.empty()) scene.lidar[index(LidarFeature::kDiscontinuity)].push_back(edge[i]);
  }
  if (scene.size() == 0) return fail("the sweep has no return between min_range and max_range");

  scene.image = picture_features(frame, options.image, options.equalize);
  return scene;
}

}  // namespace infuse::calibration

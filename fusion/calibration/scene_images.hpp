#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "fusion/calibration/feature.hpp"
#include "fusion/features/plane.hpp"

namespace infuse::calibration {

/// Plane of values 0 … 1, each in 8 bits: a quarter of the memory of a `features::Plane`.
struct CompactPlane {
  using Sample = uint8_t;
  static constexpr float kUnit = 1.0F / 255;  ///< of `values` in 8 bits

  int width = 0;   ///< samples
  int height = 0;  ///< samples
  int step = 1;    ///< pixels between samples; sample (0, 0) is pixel (0, 0)
  std::vector<Sample> values;

  float value(size_t i) const { return kUnit * static_cast<float>(values[i]); }
};

/// Rounds the values, which are limited to 0 … 1.
CompactPlane compact_plane(const features::Plane& plane);

/// Image features of one scene at several blurs, as an objective looks them up.
class SceneImages {
 public:
  using Level = std::shared_ptr<const PerImageFeature<CompactPlane>>;

  /// Blurs the features that are `wanted` by a Gaussian of each of `sigmas` (pixels, in any order),
  /// each level from the next finer one, and thins them as the blur allows. Local grey is computed
  /// of the blurred grey. Features without values stay so.
  SceneImages(const PerImageFeature<features::Plane>& image, const PerImageFeature<bool>& wanted,
              std::span<const double> sigmas);

  /// Returns the features blurred by `sigma`; null where they were not made.
  Level at(double sigma) const;

 private:
  std::map<double, Level> levels_;
};

}  // namespace infuse::calibration

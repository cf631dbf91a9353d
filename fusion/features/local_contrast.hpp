#pragma once

#include <vector>

#include "fusion/features/plane.hpp"

namespace infuse::features {

/// Width of the surroundings that a grey level is compared with, in sigmas of the image's blur.
inline constexpr double kContrastWidthPerSigma = 8;

/// Noise of a smooth surface, grey levels of 255.
inline constexpr double kGreyNoise = 2;

/// Values of a plane relative to their surroundings: (g − m) / s, m and s mean and standard
/// deviation under a Gaussian of `width` pixels, mapped to 0 … 1 by ½ + ½ z / √(1 + z²).
/// `noise_sigma` (the values' unit) is added to s as a square, so that noise on a smooth surface
/// stays small.
///
/// Removes illumination that changes slowly over the image (shadow and sun, haze, vignetting, walls
/// that get darker upwards): it depends on where things are, not on what they are.
///
/// Allocates nothing after its first plane of a size.
class LocalContrast {
 public:
  /// `out` is another plane than `plane`.
  void compute(const Plane& plane, double width, double noise_sigma, Plane& out);

 private:
  /// Position of a row's samples between those of a thinner one: the sample before, and the
  /// fraction.
  struct Interpolation {
    std::vector<int> first;
    std::vector<float> fraction;
    void resize(int samples, float scale);
  };
  void blur_in_two_steps(const Plane& plane, double sigma, int step, Plane& out);

  Blur blur_;
  Plane squared_, thin_, mean_, power_;
  Interpolation along_, down_;
  std::vector<float> means_, powers_;  // a row of `mean_` and `power_`, between two of theirs
};

/// The same as a new plane.
Plane normalize_local_contrast(const Plane& plane, double width, double noise_sigma);

}  // namespace infuse::features

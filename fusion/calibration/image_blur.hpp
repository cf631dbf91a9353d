#pragma once

#include <compare>
#include <span>
#include <vector>

#include "fusion/calibration/visible_points.hpp"

namespace infuse::calibration {

/// Gaussian blur of images before they are compared, of one or several cameras.
class ImageBlur {
 public:
  /// By `sigma` pixels, scaled by f / 500 px for cameras with a focal length f below 500 px (the
  /// same angle), but never below min(`sigma`, 1 px). Without the scaling, 8 px are 1.6° of a wide
  /// 640-pixel camera, and all ascents ended at one maximum 3° from the truth, which no finer level
  /// left.
  static ImageBlur in_angle(double sigma) { return {sigma, false}; }

  /// By `sigma` pixels whatever the camera.
  static ImageBlur in_pixels(double sigma) { return {sigma, true}; }

  /// Standard deviation of the blur of a camera's images, px.
  double sigma(const RigCamera& camera) const;

  auto operator<=>(const ImageBlur&) const = default;

 private:
  ImageBlur(double sigma, bool in_pixels) : sigma_(sigma), in_pixels_(in_pixels) {}

  double sigma_;
  bool in_pixels_;
};

/// Standard deviations of the blurs of a camera's images, px.
std::vector<double> sigmas_of(const RigCamera& camera, std::span<const ImageBlur> blurs);

}  // namespace infuse::calibration

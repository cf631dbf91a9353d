#pragma once

#include <compare>
#include <span>
#include <vector>

#include "fusion/calibration/visible_points.hpp"

namespace infuse::calibration {

/// Gaussian blur of images before they are compared, of one or several cameras.
class ImageBlur {
 public:
  /// As wide in angle as `sigma` pixels are with a focal length of 500 px where a camera's is
  /// shorter; otherwise, and where `sigma` is at most 1, by `sigma` pixels; at least 1 px. Eight
  /// pixels are 1.6° of a wide camera with 640 pixels: so blurred, all ascents led to one maximum
  /// 3° beside the truth, from which no finer level came back.
  ImageBlur(double sigma) : sigma_(sigma) {}  // NOLINT(google-explicit-constructor): what is meant

  /// By `sigma` pixels whatever the camera.
  static ImageBlur in_pixels(double sigma) {
    ImageBlur blur(sigma);
    blur.in_pixels_ = true;
    return blur;
  }

  /// Standard deviation of the blur of a camera's images, px.
  double sigma(const RigCamera& camera) const;

  auto operator<=>(const ImageBlur&) const = default;

 private:
  double sigma_;
  bool in_pixels_ = false;
};

/// Standard deviations of the blurs of a camera's images, px.
std::vector<double> sigmas_of(const RigCamera& camera, std::span<const ImageBlur> blurs);

}  // namespace infuse::calibration

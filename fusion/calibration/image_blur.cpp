#include "fusion/calibration/image_blur.hpp"

#include <algorithm>

namespace infuse::calibration {
namespace {

constexpr double kFullBlurFocalLength = 500;  // px; blurs of shorter ones are scaled (decision 5)

}  // namespace

double ImageBlur::sigma(const RigCamera& camera) const {
  const double scale = std::min(1.0, camera.model.intrinsics().fx / kFullBlurFocalLength);
  return in_pixels_ ? sigma_ : std::max(scale * sigma_, std::min(sigma_, 1.0));
}

std::vector<double> sigmas_of(const RigCamera& camera, std::span<const ImageBlur> blurs) {
  std::vector<double> sigmas;
  for (const ImageBlur& blur : blurs) sigmas.push_back(blur.sigma(camera));
  return sigmas;
}

}  // namespace infuse::calibration

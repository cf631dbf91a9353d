#include "fusion/calibration/image_pyramid.hpp"

#include <algorithm>
#include <iterator>
#include <vector>

namespace infuse::calibration {

ImagePyramid::ImagePyramid(std::span<const Scene> scenes, std::span<const TermOptions> terms,
                           std::span<const double> sigmas)
    : scenes_(scenes), terms_(terms.begin(), terms.end()) {
  std::vector<double> ascending(sigmas.begin(), sigmas.end());
  std::sort(ascending.begin(), ascending.end());
  for (const double sigma : ascending) at(sigma);
}

const BlurredImages& ImagePyramid::at(double sigma) {
  // From the next less blurred images, if any: that is cheapest.
  const auto next = images_.lower_bound(sigma);
  if (next != images_.end() && next->first == sigma) return next->second;
  if (next == images_.begin())
    return images_.try_emplace(sigma, scenes_, terms_, sigma).first->second;
  return images_.try_emplace(sigma, std::prev(next)->second, sigma).first->second;
}

}  // namespace infuse::calibration

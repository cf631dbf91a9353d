#include "fusion/calibration/image_pyramid.hpp"

#include <optional>
#include <stdexcept>
#include <utility>

namespace infuse::calibration {

ImagePyramid::ImagePyramid(std::span<const Scene> scenes, std::span<const TermOptions> terms,
                           std::span<const double> sigmas)
    : scenes_(scenes), terms_(terms.begin(), terms.end()) {
  const PerImageFeature<bool> compared = compared_image_features(terms_);
  std::map<double, std::vector<SceneImages::Level>> levels;
  for (const double sigma : sigmas) levels[sigma].reserve(scenes_.size());
  for (const Scene& scene : scenes_) {
    // One at a time: between the levels a scene's images take several times as much memory.
    std::optional<SceneImages> made;
    if (scene.blurred == nullptr) made.emplace(scene.image, compared, sigmas);
    const SceneImages& images = made ? *made : *scene.blurred;
    for (auto& [sigma, level] : levels) {
      level.push_back(images.at(sigma));
      if (level.back() == nullptr) throw std::logic_error("a scene is not prepared for this blur");
    }
  }
  for (auto& [sigma, level] : levels) images_.try_emplace(sigma, std::move(level));
}

const BlurredImages& ImagePyramid::at(double sigma) {
  const auto found = images_.find(sigma);
  return found != images_.end() ? found->second
                                : images_.try_emplace(sigma, scenes_, terms_, sigma).first->second;
}

}  // namespace infuse::calibration

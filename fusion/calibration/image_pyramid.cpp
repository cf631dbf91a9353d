#include "fusion/calibration/image_pyramid.hpp"

#include <optional>
#include <stdexcept>
#include <utility>

namespace infuse::calibration {

ImagePyramid::ImagePyramid(std::span<const Scene> scenes, std::span<const RigCamera> cameras,
                           std::span<const TermOptions> terms, std::span<const ImageBlur> blurs)
    : scenes_(scenes), cameras_(cameras), terms_(terms.begin(), terms.end()) {
  const PerImageFeature<bool> compared = compared_image_features(terms_);
  std::map<ImageBlur, std::vector<SceneImages::Level>> levels;
  for (const ImageBlur& blur : blurs) levels[blur].reserve(scenes_.size());
  for (const Scene& scene : scenes_) {
    // One at a time: between the levels a scene's images take several times as much memory.
    const RigCamera& camera = cameras_[scene.camera];
    std::optional<SceneImages> made;
    if (scene.blurred == nullptr) made.emplace(scene.image, compared, sigmas_of(camera, blurs));
    const SceneImages& images = made ? *made : *scene.blurred;
    for (auto& [blur, level] : levels) {
      level.push_back(images.at(blur.sigma(camera)));
      if (level.back() == nullptr) throw std::logic_error("a scene is not prepared for this blur");
    }
  }
  for (auto& [blur, level] : levels) images_.try_emplace(blur, std::move(level));
}

const BlurredImages& ImagePyramid::at(const ImageBlur& blur) {
  const auto found = images_.find(blur);
  return found != images_.end()
             ? found->second
             : images_.try_emplace(blur, scenes_, cameras_, terms_, blur).first->second;
}

}  // namespace infuse::calibration

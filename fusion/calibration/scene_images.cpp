#include "fusion/calibration/scene_images.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fusion/features/local_contrast.hpp"

namespace infuse::calibration {
namespace {

constexpr double kMinContrastWidth = 15;                    // px, of the surroundings of local grey
constexpr double kNoiseSigma = features::kGreyNoise / 255;  // for grey 0 … 1

/// Largest power of two, px, that the Gaussian's sigma is not smaller than.
int sample_step(double sigma) {
  int step = 1;
  while (2 * step <= sigma) step *= 2;
  return step;
}

}  // namespace

CompactPlane compact_plane(const features::Plane& plane) {
  CompactPlane out{.width = plane.width, .height = plane.height, .step = plane.step, .values = {}};
  out.values.reserve(plane.values.size());
  for (const float value : plane.values) {
    const float limited = value > 0.0F ? std::min(value, 1.0F) : 0.0F;
    out.values.push_back(static_cast<CompactPlane::Sample>(limited / CompactPlane::kUnit + 0.5F));
  }
  return out;
}

SceneImages::SceneImages(const PerImageFeature<features::Plane>& image,
                         const PerImageFeature<bool>& wanted, std::span<const double> sigmas) {
  std::vector<double> ascending(sigmas.begin(), sigmas.end());
  std::sort(ascending.begin(), ascending.end());
  PerImageFeature<features::Plane> finer;
  double finer_sigma = 0;
  for (const double sigma : ascending) {
    if (levels_.contains(sigma)) continue;
    const double rest = std::sqrt(std::max(0.0, sigma * sigma - finer_sigma * finer_sigma));
    const double width = std::max(kMinContrastWidth, features::kContrastWidthPerSigma * sigma);
    auto level = std::make_shared<PerImageFeature<CompactPlane>>();
    for (size_t f = 0; f < kImageFeatures; ++f) {
      const features::Plane& from = levels_.empty() ? image[f] : finer[f];
      if (!wanted[f] || from.values.empty()) continue;
      features::Plane blurred =
          features::blurred(from, rest, std::max(from.step, sample_step(sigma)));
      (*level)[f] =
          compact_plane(f == index(ImageFeature::kLocalGrey)
                            ? features::normalize_local_contrast(blurred, width, kNoiseSigma)
                            : blurred);
      finer[f] = std::move(blurred);
    }
    levels_.emplace(sigma, std::move(level));
    finer_sigma = sigma;
  }
}

SceneImages::Level SceneImages::at(double sigma) const {
  const auto found = levels_.find(sigma);
  return found == levels_.end() ? nullptr : found->second;
}

}  // namespace infuse::calibration

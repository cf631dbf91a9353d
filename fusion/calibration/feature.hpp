#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace infuse::calibration {

/// Feature of a return.
enum class LidarFeature : uint8_t {
  kReflectivity,           ///< as the sensor states it, 0 … 1
  kRelativeReflectivity,   ///< `features::RelativeReflectivity`
  kDiscontinuity,          ///< scan discontinuity, I(3.6), `features::Discontinuity`
  kRelativeDiscontinuity,  ///< the same by rank within the ring
  kNormalX,                ///< surface normal, lidar frame, facing the sensor, I 4.3.1.3
  kNormalY,
  kNormalZ,
};
inline constexpr size_t kLidarFeatures = static_cast<size_t>(LidarFeature::kNormalZ) + 1;

/// Feature of a pixel.
enum class ImageFeature : uint8_t {
  kGrey,
  kLocalGrey,  ///< grey relative to its surroundings, `features::LocalContrast`
  kRingEdge,   ///< change of grey along the lidar's rings, `features::RingEdge`
  kEdge,       ///< edge strength, I 4.3.1.4
  kRed,
  kGreen,
  kBlue,
};
inline constexpr size_t kImageFeatures = static_cast<size_t>(ImageFeature::kBlue) + 1;

/// Number of bins of each side of a joint histogram of two features.
inline constexpr int kHistogramBins = 16;

/// One entry per lidar feature.
template <class T>
using PerLidarFeature = std::array<T, kLidarFeatures>;
/// One entry per image feature.
template <class T>
using PerImageFeature = std::array<T, kImageFeatures>;

/// True for features of depth edges: only returns near an edge can be compared by them.
constexpr bool is_edge(LidarFeature feature) {
  return feature == LidarFeature::kDiscontinuity || feature == LidarFeature::kRelativeDiscontinuity;
}

constexpr size_t index(LidarFeature feature) { return static_cast<size_t>(feature); }
constexpr size_t index(ImageFeature feature) { return static_cast<size_t>(feature); }

}  // namespace infuse::calibration

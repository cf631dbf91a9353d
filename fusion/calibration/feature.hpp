#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace infuse::calibration {

/// What a return tells of the surface it came from.
enum class LidarFeature : uint8_t {
  kReflectivity,           ///< as the sensor states it, 0 … 1
  kRelativeReflectivity,   ///< by rank among the returns of its beam at like range
  kDiscontinuity,          ///< scan discontinuity, I(3.6)
  kRelativeDiscontinuity,  ///< the same by rank within its ring
  kNormalX,                ///< surface normal, lidar frame, turned towards the sensor, I 4.3.1.3
  kNormalY,
  kNormalZ,
};
inline constexpr size_t kLidarFeatures = 7;

/// What a picture tells at a pixel.
enum class ImageFeature : uint8_t {
  kGrey,
  kLocalGrey,  ///< grey against its surroundings
  kRingEdge,   ///< change of grey along the lidar's rings
  kEdge,       ///< edge strength, I 4.3.1.4
  kRed,
  kGreen,
  kBlue,
};
inline constexpr size_t kImageFeatures = 7;

/// One entry a lidar feature.
template <class T>
using PerLidarFeature = std::array<T, kLidarFeatures>;
/// One entry an image feature.
template <class T>
using PerImageFeature = std::array<T, kImageFeatures>;

/// Of depth edges: only returns that have one beside them can be compared by it.
constexpr bool is_edge(LidarFeature feature) {
  return feature == LidarFeature::kDiscontinuity || feature == LidarFeature::kRelativeDiscontinuity;
}

constexpr size_t index(LidarFeature feature) { return static_cast<size_t>(feature); }
constexpr size_t index(ImageFeature feature) { return static_cast<size_t>(feature); }

}  // namespace infuse::calibration

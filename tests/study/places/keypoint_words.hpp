#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "fusion/places/visual/scan_words.hpp"
#include "fusion/registration/visual/codebook.hpp"
#include "tests/study/places/season_drive.hpp"

namespace infuse::study {

/// SIFT descriptors at returns of a scan, one per column. Throws std::runtime_error.
Eigen::MatrixXf sift_descriptors(const SeasonScan& scan, const Rig& rig);

/// A codeword of SIFT at a return.
struct Keypoint {
  Eigen::Vector3f point;  ///< m, about the vehicle
  uint16_t word = 0;      ///< of the codebook
};

/// The keypoints of a scan within 39 m. Throws std::runtime_error.
std::vector<Keypoint> find_keypoints(const SeasonScan& scan, const Rig& rig,
                                     const registration::Codebook& codebook);

/// The keypoints of a place, prepared for look-ups.
class MapKeypoints {
 public:
  explicit MapKeypoints(std::vector<Keypoint> keypoints);

  /// Information about the words of a query whose vehicle is at x, y (m) with the heading yaw. A
  /// keypoint corresponds to one of its word within 1.5 m, else to the nearest, P 5.2.2.
  double information(const std::vector<Keypoint>& query, double x, double y, double yaw) const;

 private:
  int corresponding(const Eigen::Vector3f& point, uint16_t word) const;  // its word; −1: none
  std::vector<Keypoint> keypoints_;
  std::vector<std::vector<uint32_t>> at_;  // by voxel
};

/// Feature sets of P 5.3.1.
enum class FeatureSet : uint8_t {
  kReflectivityNormal,      ///< fused at the information level, P(5.1)
  kReflectivityGreyNormal,  ///< reflectivity and grey fused at the signal level, P 5.2.1.1
  kSift,
  kReflectivityNormalSift,
  kAll,  ///< reflectivity and grey, normals, SIFT
};
inline constexpr int kFeatureSets = 5;
const char* name_of(FeatureSet set);

/// Total mutual information P(5.6) of the feature sets at one transform.
std::array<double, kFeatureSets> information_of_sets(const places::TotalInformation& voxels,
                                                     double sift);

}  // namespace infuse::study

#pragma once

#include <array>
#include <vector>

#include "fusion/registration/visual/codebook.hpp"
#include "tests/study/places/season_drive.hpp"

namespace infuse::study {

/// Quantised features of a scan in voxels of 1 m about the vehicle (upright frame, x ahead), P
/// 5.2.1.
struct ScanWords {
  /// A voxel with returns. Levels are −1 where the feature is unknown.
  struct Voxel {
    Eigen::Vector3f centre;     ///< m, mean of its returns
    int16_t reflectivity = -1;  ///< 0 … 7
    int16_t grey = -1;          ///< 0 … 7, rank within its image
    int16_t tilt = -1;          ///< of the normal: 0 upright, 1 slanted, 2 level
    float azimuth = 0;          ///< rad, of the normal, modulo π
  };
  struct Keypoint {
    Eigen::Vector3f point;  ///< m
    uint16_t word = 0;      ///< of the codebook of SIFT
  };
  std::vector<Voxel> voxels;
  std::vector<Keypoint> keypoints;
};

/// SIFT descriptors at returns of a scan, one per column. Throws std::runtime_error.
Eigen::MatrixXf sift_descriptors(const SeasonScan& scan, const Rig& rig);

/// Describes a scan. Throws std::runtime_error.
ScanWords describe_scan(const SeasonScan& scan, const Rig& rig,
                        const registration::Codebook& codebook);

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
using SetInformation = std::array<double, kFeatureSets>;

/// A scan of the map, prepared for look-ups.
class MapScan {
 public:
  explicit MapScan(ScanWords words);
  const ScanWords& words() const { return words_; }

  /// Total mutual information with a scan whose vehicle is at x, y (m) with the heading yaw as seen
  /// from this one; entropies by Chao and Shen, P(5.5). Of each kind times the share of the scan's
  /// features that have a counterpart.
  SetInformation information(const ScanWords& query, double x, double y, double yaw) const;

 private:
  int cell(const Eigen::Vector3f& p) const;
  ScanWords words_;
  std::vector<int32_t> voxel_at_;                    // by cell; −1: none
  std::vector<std::vector<uint32_t>> keypoints_at_;  // by cell
};

/// Mutual information of pairs of words by Chao–Shen entropies, nats; 0 of fewer than 20 pairs.
double word_information(const std::vector<std::pair<int, int>>& pairs);

}  // namespace infuse::study

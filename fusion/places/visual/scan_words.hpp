#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <utility>
#include <vector>

#include "fusion/registration/visual/camera_lidar_scan.hpp"

namespace infuse::places {

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
  std::vector<Voxel> voxels;
};

/// Describes a scan. Grey levels come from its images, of which there may be none.
ScanWords describe_scan(const registration::CameraLidarScan& scan,
                        const Eigen::Isometry3d& T_vehicle_lidar);

/// Total mutual information P(5.6) of two scans at one transform, by kind of feature: of each kind
/// times the share of the query's features that have a counterpart, nats.
struct TotalInformation {
  double reflectivity = 0;
  double reflectivity_grey = 0;  ///< both fused at the signal level, P 5.2.1.1
  double normals = 0;

  /// Fused at the information level, P(5.1); with grey levels where images show the scans.
  double total(bool grey) const { return (grey ? reflectivity_grey : reflectivity) + normals; }
};

/// Voxels about a place: ±40 m along and across, −2 … 12 m.
inline constexpr int kPlaceSide = 80, kPlaceLayers = 14;
inline constexpr int kPlaceVoxels = kPlaceSide * kPlaceSide * kPlaceLayers;

/// Index of the voxel of a point (m), or −1 outside.
int voxel_index(const Eigen::Vector3f& point);

/// A scan of the map, prepared for look-ups.
class MapScan {
 public:
  explicit MapScan(ScanWords words);
  const ScanWords& words() const { return words_; }

  /// Information about a scan whose vehicle is at x, y (m) with the heading yaw (rad) as seen from
  /// this one; entropies by Chao and Shen, P(5.5).
  TotalInformation information(const ScanWords& query, double x, double y, double yaw) const;

 private:
  ScanWords words_;
  std::vector<int32_t> voxel_at_;  // by index; −1: none
};

/// Mutual information of pairs of words by Chao–Shen entropies times the share of the `features`
/// that are paired, nats; 0 of fewer than 20 pairs. A feature without a counterpart states nothing:
/// without the share a few pairs by chance would win, as joint entropies of few pairs are too low.
double word_information(const std::vector<std::pair<int, int>>& pairs, size_t features);

/// Where a query was seen from a place, and the information there.
struct InformationAlignment {
  double x = 0, y = 0, yaw = 0;  ///< m, rad
  TotalInformation information;
};

/// The best transform of a grid about the place (±4 m ahead, ±6 m aside: other lanes, and places up
/// to half their spacing away), at the heading `yaw` and its opposite.
InformationAlignment search_by_information(const MapScan& place, const ScanWords& query, double yaw,
                                           bool grey);

/// The best transform near a guess, to 0.5 m and 1°.
InformationAlignment refine_by_information(const MapScan& place, const ScanWords& query,
                                           InformationAlignment guess, bool grey);

}  // namespace infuse::places

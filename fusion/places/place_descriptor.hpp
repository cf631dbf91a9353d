#pragma once

#include <Eigen/Core>

#include "fusion/geometry/project_points.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::places {

inline constexpr int kRings =
    20;  ///< of equal width, up to `kMaxDescribedRange` (Kim and Kim 2018)
inline constexpr int kSectors =
    60;  ///< of azimuth, counter-clockwise from the vehicle's x (Kim and Kim 2018)
inline constexpr int kHarmonics = 6;              ///< of azimuth, in the key (decision 17)
inline constexpr double kMaxDescribedRange = 80;  ///< m (Kim and Kim 2018)
inline constexpr double kHeightStep = 0.05;       ///< m; heights are multiples (decision 17)
inline constexpr double kMaxDescribedHeight = 255 * kHeightStep;  ///< m; heights are bytes

/// Shape of a place as a polar map of the heights around it (as Scan Context, Kim and Kim 2018):
/// turning the vehicle shifts its columns, a few metres of displacement change little.
struct PlaceDescriptor {
  /// Height of the highest point of each ring and sector above the ground, m; 0: nothing above it.
  Eigen::Matrix<float, kRings, kSectors> heights = decltype(heights)::Zero();
};

/// What a search compares first: of every ring, the magnitudes of the lowest harmonics of azimuth.
/// Independent of the heading; of unit length, or 0 where there is nothing.
using PlaceKey = Eigen::Matrix<float, kRings * kHarmonics, 1>;

/// Describes points (lidar frame, m) about the vehicle, whose z axis points up.
PlaceDescriptor describe_place(const geometry::PointsView& points,
                               const Eigen::Isometry3d& T_vehicle_lidar);

PlaceKey key_of(const PlaceDescriptor& descriptor);

/// How alike two places are, and the heading between them.
struct PlaceSimilarity {
  double correlation = 0;  ///< −1 … 1, of the heights at the best heading
  double yaw = 0;          ///< rad, heading of `source` in the frame of `target`, by sectors
};

/// Correlates the heights at every heading.
PlaceSimilarity compare_places(const PlaceDescriptor& target, const PlaceDescriptor& source);

}  // namespace infuse::places

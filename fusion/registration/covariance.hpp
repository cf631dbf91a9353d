#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fusion/features/neighbour_search.hpp"
#include "fusion/registration/lengths.hpp"
#include "fusion/registration/point_cloud.hpp"

namespace infuse::registration {

using features::NeighbourSearch;

/// Settings of the local planes.
struct CovarianceOptions {
  int neighbours = 10;  ///< number of points, the point itself included, of a local plane
  int min_neighbours = kMinPlanePoints;  ///< fewer give no plane
  /// Sine of the smallest angle between a plane and the ray from the origin to its point, 0 … 1;
  /// `kMinIncidence` for points that a lidar at the origin measured. Of trees, hedges and fences a
  /// beam returns a curve that lies in its own cone, and the plane through that curve would hold a
  /// second cloud to the rings of the first. 0: all planes, for clouds of any origin.
  double min_incidence = 0;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Estimates the local covariance of every point of the tree, P 4.2.2: of a plane of variance 1
/// along it and ε across, so that its normal (of either sign) says all. Sets the normals of
/// `cloud`; `search` must have been built from it, and has the caller's `memory`. Same bytes on
/// every processor.
void estimate_covariances(const NeighbourSearch& search, const CovarianceOptions& options,
                          std::vector<NeighbourSearch::Point>& memory, PointCloud& cloud);

}  // namespace infuse::registration

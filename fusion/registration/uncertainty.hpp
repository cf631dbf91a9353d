#pragma once

#include <vector>

#include "fusion/registration/pose_system.hpp"

namespace infuse::registration {

/// Directions in which planes determine a pose, as columns 0 … count − 1 of `basis`: orthogonal
/// twists about the points' middle, in units of the points' displacement by them (root mean square,
/// m). The other columns are the free directions.
struct DeterminedDirections {
  geometry::Matrix6 basis = geometry::Matrix6::Identity();
  int count = 6;
  /// Twist about the origin of a twist in the units of the basis.
  geometry::Matrix6 twist_from_scaled = geometry::Matrix6::Identity();
};

/// Finds the directions that the planes see: the part of the points' displacement that is along the
/// normals is at least `min_plane_fraction` (in squares). Noise tilts the normals of level ground
/// in all directions, and rings of returns on it would seem to show how far the vehicle moved:
/// normals that may be the commonest one count as that.
DeterminedDirections determined_directions(const Pairs& pairs, const PoseSystem& system,
                                           const PairNoise& noise, double min_plane_fraction);

/// Gauss–Newton step in the determined directions.
geometry::Vector6 determined_step(const PoseSystem& system, const DeterminedDirections& determined);

/// Sets covariance, information and free directions of a result at its optimum. Neighbouring points
/// err together (the surface is not the plane, both sweeps saw it from elsewhere), so the residuals
/// are not independent: their gradients are summed over clusters of `cluster_size` (m), and the
/// scatter of those sums is what the pose's error comes from ("sandwich" covariance, White 1982;
/// Liang and Zeger 1986). `clusters` is working memory.
void set_uncertainty(const Pairs& pairs, const PairNoise& noise, const PoseSystem& system,
                     const DeterminedDirections& determined,
                     std::vector<geometry::Vector6>& clusters, RegistrationResult& result);

}  // namespace infuse::registration

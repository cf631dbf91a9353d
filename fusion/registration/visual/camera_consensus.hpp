#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "drivers/measurement/rig.hpp"

namespace infuse::registration {

/// Camera consensus matrix, P 4.2.1.1: entry (i, j) states how much camera i of the target and
/// camera j of the source show of the same, 0 … 1.
using ConsensusMatrix = Eigen::MatrixXd;

/// Returns the ideal matrices of a rig, entries 0 or 1, each once: for every heading, at the same
/// place and moved by half the distance of the scene in any direction, which cameras of the target
/// see at least a quarter of what a camera of the source sees at that distance. Made from the rig's
/// own geometry (in place of P's table for a ring of five); directions lie in the horizontal plane
/// of the lidar.
std::vector<ConsensusMatrix> ideal_consensus(std::span<const CameraMount> cameras);

/// Scales every row to a maximum of 1, P(4.2); rows of zeros stay.
ConsensusMatrix normalise_rows(const ConsensusMatrix& measured);

/// Returns the index of the ideal matrix with the least orthogonal distance from the measured one,
/// P(4.3), both as vectors. P's formula divides by the norms of both vectors; the orthogonal
/// projection that the text describes divides by the squared norm of the ideal one.
size_t nearest_consensus(const ConsensusMatrix& measured, std::span<const ConsensusMatrix> ideal);

}  // namespace infuse::registration

#pragma once

#include "fusion/mapping/pose_graph.hpp"

namespace infuse::mapping {

/// Sets all poses but the first from the edges alone: rotations by the least squares of the chordal
/// cost without the constraint that they are rotations, projected on them (Carlone et al. 2015),
/// then positions by linear least squares. Returns false, and changes nothing, if the edges do not
/// determine the poses.
template <int D>
bool initialise_chordal(PoseGraph<D>& graph);

}  // namespace infuse::mapping

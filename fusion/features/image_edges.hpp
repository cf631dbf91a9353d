#pragma once

#include <vector>

#include "fusion/features/plane.hpp"
#include "fusion/features/ring_directions.hpp"

namespace infuse::features {

/// Edge strength after Levinson and Thrun, I 4.3.1.4:
///   e(u, v) = max over the eight neighbours of |I(u, v) − I(u', v')|,
/// 0 … 255 for grey levels; at the border over the neighbours that exist.
Plane edge_strength(const Plane& grey);

/// Change of grey along the lidar's rings: |n · ∇I|, n the ring's direction and ∇I Sobel's
/// derivatives, 0 … 255 for grey levels, borders replicated.
///
/// A return has an edge where its neighbours *on its ring* lie farther (I 3.6), and a ring does not
/// see the edges that it runs along: kerbs, eaves and the horizon are image edges without a
/// counterpart in the lidar, and shifted the maximum of the measure by up to a degree. Sobel's
/// smoothing also suppresses more noise than the largest step to a neighbour does.
///
/// Allocates nothing after its first plane of a size.
class RingEdge {
 public:
  /// `out` is another plane than `grey`.
  void compute(const Plane& grey, const RingDirections& rings, Plane& out);

 private:
  std::vector<float> right_, down_;          // the ring's direction by sample of a row
  std::vector<float> above_, here_, below_;  // rows with their first and last sample once more
};

/// The same as a new plane.
Plane ring_edge(const Plane& grey, const RingDirections& rings);

}  // namespace infuse::features

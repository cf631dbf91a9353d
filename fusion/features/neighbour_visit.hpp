#pragma once

#include <cmath>

#include "fusion/features/neighbour_search.hpp"

namespace infuse::features {

inline constexpr size_t kMaxDepth =
    28;  ///< of the tree, with 2^28 leaves: bounds memory on the stack

/// Box around the points of a search.
struct Box {
  float low[3], high[3];
};

/// Squared distances of a leaf's points from a box.
[[gnu::always_inline]] inline Floats square_distances(const NeighbourSearch::Leaf& leaf,
                                                      const Box& box) {
  Floats sum = {};
  const Floats* at[3] = {&leaf.x, &leaf.y, &leaf.z};
  for (int axis = 0; axis < 3; ++axis) {
    const Floats below = box.low[axis] - *at[axis], above = *at[axis] - box.high[axis];
    Floats outside = below > above ? below : above;
    outside = outside > 0 ? outside : Floats{};
    sum += outside * outside;
  }
  return sum;
}

/// Part of the tree that is still to be visited: its node, and the distance of its cell from the
/// box, squared and by axis.
struct Pending {
  size_t node;
  float square_distance;
  float offset[3];
};

/// Visits the leaves that may hold a point nearer to the box than `found.bound()`, the nearest
/// first.
template <class Found>
[[gnu::always_inline]] inline void visit(const NeighbourSearch::Split* splits, size_t inner_nodes,
                                         const NeighbourSearch::Leaf* leaves, const Box& box,
                                         Found& found) {
  Pending stack[kMaxDepth];
  size_t pending = 0;
  Pending at{0, 0, {0, 0, 0}};
  for (;;) {
    while (at.node < inner_nodes) {
      const NeighbourSearch::Split& split = splits[at.node];
      const float below = box.low[split.axis] - split.value;
      const float above = split.value - box.high[split.axis];
      const bool right = below > above;  // more of the box is right of the plane
      const size_t left = 2 * at.node + 1;
      Pending& far = stack[pending];
      far = at;
      far.node = left + (right ? 0 : 1);
      const float side = right ? below : above;
      if (side > 0) {  // all of it
        const float old = at.offset[split.axis];
        far.offset[split.axis] = side;
        far.square_distance += side * side - old * old;
      }
      if (far.square_distance < found.bound()) ++pending;
      at.node = left + (right ? 1 : 0);
    }
    found.add(leaves[at.node - inner_nodes]);
    do {
      if (pending == 0) return;
      at = stack[--pending];
    } while (!(at.square_distance < found.bound()));
  }
}

/// Smallest of 16 numbers.
[[gnu::always_inline]] inline float minimum(const Floats& v) {
  Floats m = v;
  Floats other =
      __builtin_shufflevector(m, m, 8, 9, 10, 11, 12, 13, 14, 15, 0, 1, 2, 3, 4, 5, 6, 7);
  m = m < other ? m : other;
  other = __builtin_shufflevector(m, m, 4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11);
  m = m < other ? m : other;
  const float a = m[0] < m[1] ? m[0] : m[1];
  const float b = m[2] < m[3] ? m[2] : m[3];
  return a < b ? a : b;
}

/// Largest of 16 numbers.
[[gnu::always_inline]] inline float maximum(const Floats& v) { return -minimum(-v); }

}  // namespace infuse::features

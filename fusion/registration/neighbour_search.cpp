#include "fusion/registration/neighbour_search.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "drivers/measurement/simd.hpp"

namespace infuse::registration {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr size_t kMaxDepth = 28;

/// Part of the tree that is still to be visited: its node, and the distance of its cell from the
/// query, squared and by axis.
struct Pending {
  size_t node;
  float square_distance;
  float offset[3];
};

/// Visits the leaves that may hold a point closer than `found.bound()`, the nearest first.
template <class Found>
[[gnu::always_inline]] inline void visit(const NeighbourSearch::Split* splits, size_t inner_nodes,
                                         const NeighbourSearch::Leaf* leaves, const float* point,
                                         Found& found) {
  Pending stack[kMaxDepth];
  size_t pending = 0;
  Pending at{0, 0, {0, 0, 0}};
  for (;;) {
    while (at.node < inner_nodes) {
      const NeighbourSearch::Split& split = splits[at.node];
      const float side = point[split.axis] - split.value;
      const size_t left = 2 * at.node + 1;
      const bool right = side > 0;
      Pending& far = stack[pending];
      far = at;
      far.node = left + (right ? 0 : 1);
      const float old = at.offset[split.axis];
      far.offset[split.axis] = side;
      far.square_distance += side * side - old * old;
      if (far.square_distance < found.bound()) ++pending;
      at.node = left + (right ? 1 : 0);
    }
    const NeighbourSearch::Leaf& leaf = leaves[at.node - inner_nodes];
    const Floats dx = leaf.x - point[0], dy = leaf.y - point[1], dz = leaf.z - point[2];
    const Floats square = dx * dx + dy * dy + dz * dz;
    found.add(square, leaf.index);
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

/// Nearest point, and the distance within which there is no other.
struct FoundNearest {
  float best, second;  // squared
  float margin;
  float limit;  // squared: what is farther away need not be visited
  int32_t index = -1;

  [[gnu::always_inline]] float bound() const { return limit; }
  [[gnu::always_inline]] void add(const Floats& square, const int32_t* indices) {
    if (!(minimum(square) < limit)) return;
    for (int i = 0; i < kLanes; ++i) {
      if (!(square[i] < second)) continue;
      if (square[i] < best) {
        second = best;
        best = square[i];
        index = indices[i];
      } else {
        second = square[i];
      }
    }
    const float reach = std::sqrt(best) + margin;
    limit = std::min(second, reach * reach);
  }
};

/// The nearest points, sorted.
struct FoundNeighbours {
  int wanted;
  int count = 0;
  int32_t* indices;
  float* squares;
  float limit = kInfinity;

  [[gnu::always_inline]] float bound() const { return limit; }
  [[gnu::always_inline]] void add(const Floats& square, const int32_t* leaf_indices) {
    if (!(minimum(square) < limit)) return;
    for (int i = 0; i < kLanes; ++i) {
      const float value = square[i];
      if (!(value < limit)) continue;
      int at = count < wanted ? count++ : wanted - 1;
      for (; at > 0 && squares[at - 1] > value; --at) {
        squares[at] = squares[at - 1];
        indices[at] = indices[at - 1];
      }
      squares[at] = value;
      indices[at] = leaf_indices[i];
      if (count == wanted) limit = squares[wanted - 1];
    }
  }
};

INFUSE_SIMD_CLONES void find_nearest(const NeighbourSearch::Split* splits, size_t inner_nodes,
                                     const NeighbourSearch::Leaf* leaves, const float* point,
                                     FoundNearest& found) {
  FoundNearest local = found;
  visit(splits, inner_nodes, leaves, point, local);
  found = local;
}

INFUSE_SIMD_CLONES void find_neighbours(const NeighbourSearch::Split* splits, size_t inner_nodes,
                                        const NeighbourSearch::Leaf* leaves, const float* point,
                                        FoundNeighbours& found) {
  FoundNeighbours local = found;
  visit(splits, inner_nodes, leaves, point, local);
  found = local;
}

}  // namespace

void NeighbourSearch::build(const geometry::PointsView& points) {
  entries_.clear();
  entries_.reserve(points.x.size());
  for (size_t i = 0; i < points.x.size(); ++i) {
    const Entry entry{{points.x[i], points.y[i], points.z[i]}, static_cast<int32_t>(i)};
    const bool finite =
        std::isfinite(entry.at[0]) && std::isfinite(entry.at[1]) && std::isfinite(entry.at[2]);
    if (finite) entries_.push_back(entry);
  }
  size_ = entries_.size();
  const size_t leaves = std::bit_ceil((size_ + kLanes - 1) / kLanes);
  leaves_.resize(leaves);
  splits_.resize(leaves - 1);
  build_node(0, 0, size_);
}

void NeighbourSearch::build_node(size_t node, size_t begin, size_t end) {
  if (node >= splits_.size()) {
    Leaf& leaf = leaves_[node - splits_.size()];
    for (size_t i = 0; i < kLanes; ++i) {
      const bool used = begin + i < end;
      const Entry entry = used ? entries_[begin + i] : Entry{{kInfinity, kInfinity, kInfinity}, -1};
      leaf.x[i] = entry.at[0];
      leaf.y[i] = entry.at[1];
      leaf.z[i] = entry.at[2];
      leaf.index[i] = entry.index;
    }
    return;
  }
  float low[3] = {kInfinity, kInfinity, kInfinity}, high[3] = {-kInfinity, -kInfinity, -kInfinity};
  for (size_t i = begin; i < end; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], entries_[i].at[axis]);
      high[axis] = std::max(high[axis], entries_[i].at[axis]);
    }
  }
  int axis = 0;
  for (int other = 1; other < 3; ++other) {
    if (high[other] - low[other] > high[axis] - low[axis]) axis = other;
  }
  const size_t middle = begin + (end - begin + 1) / 2;
  const auto at = [&](size_t i) { return entries_.begin() + static_cast<ptrdiff_t>(i); };
  float value = 0;
  if (middle < end) {
    std::nth_element(at(begin), at(middle), at(end), [axis](const Entry& a, const Entry& b) {
      return a.at[axis] < b.at[axis] || (a.at[axis] == b.at[axis] && a.index < b.index);
    });
    value = entries_[middle].at[axis];
  }
  splits_[node] = {value, axis};
  build_node(2 * node + 1, begin, middle);
  build_node(2 * node + 2, middle, end);
}

Nearest NeighbourSearch::nearest(const float* point, float max_distance, float margin) const {
  if (size_ == 0) return {};
  // The nearest is sought within max_distance, any other within the margin beyond it.
  const float reach = max_distance + margin;
  FoundNearest found{reach * reach, reach * reach, margin, reach * reach, -1};
  find_nearest(splits_.data(), splits_.size(), leaves_.data(), point, found);
  const bool near = found.index >= 0 && found.best <= max_distance * max_distance;
  if (!near) return {-1, 0, found.index >= 0 ? std::sqrt(found.best) : reach};
  return {found.index, found.best, std::sqrt(found.limit)};
}

int NeighbourSearch::nearest_neighbours(const float* point, int neighbours, int32_t* indices,
                                        float* square_distances) const {
  if (size_ == 0) return 0;
  FoundNeighbours found{.wanted = neighbours, .indices = indices, .squares = square_distances};
  find_neighbours(splits_.data(), splits_.size(), leaves_.data(), point, found);
  return found.count;
}

}  // namespace infuse::registration

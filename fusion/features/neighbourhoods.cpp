#include <algorithm>
#include <limits>

#include "drivers/measurement/simd.hpp"
#include "fusion/features/neighbour_visit.hpp"

namespace infuse::features {
namespace {

constexpr float kEverywhere = std::numeric_limits<float>::infinity();

/// The squared distances of the nearest points of each of 16 points, sorted, and the points among
/// which they are.
struct FoundNeighbours {
  const Floats* queries;  // x, y, z
  const Box& box;
  int wanted;
  std::vector<NeighbourSearch::Point>& candidates;
  Floats squares[NeighbourSearch::kMaxNeighbours];
  float limit = kEverywhere;

  [[gnu::always_inline]] float bound() const { return limit; }
  [[gnu::always_inline]] void add(const NeighbourSearch::Leaf& leaf) {
    const Floats from_box = square_distances(leaf, box);
    for (int i = 0; i < kLanes; ++i) {
      if (!(from_box[i] < limit)) continue;
      candidates.push_back({leaf.x[i], leaf.y[i], leaf.z[i]});
      const Floats dx = leaf.x[i] - queries[0], dy = leaf.y[i] - queries[1],
                   dz = leaf.z[i] - queries[2];
      Floats square = dx * dx + dy * dy + dz * dz;
      for (int k = 0; k < wanted; ++k) {
        const Floats former = squares[k];
        const Flags nearer = square < former;
        squares[k] = nearer ? square : former;
        square = nearer ? former : square;
      }
    }
    limit = maximum(squares[wanted - 1]);
  }
};

INFUSE_SIMD_CLONES void sum_neighbours(const NeighbourSearch::Split* splits, size_t inner_nodes,
                                       const NeighbourSearch::Leaf* leaves, FoundNeighbours& found,
                                       Neighbourhoods& out) {
  visit(splits, inner_nodes, leaves, found.box, found);
  const Floats* queries = found.queries;
  const Floats last = found.squares[found.wanted - 1];
  Neighbourhoods sums = {};
  for (const NeighbourSearch::Point& point : found.candidates) {
    Floats dx = point.x - queries[0], dy = point.y - queries[1], dz = point.z - queries[2];
    const Flags near = dx * dx + dy * dy + dz * dz <= last;
    const Floats zero = {}, one = zero + 1;
    dx = near ? dx : zero;
    dy = near ? dy : zero;
    dz = near ? dz : zero;
    sums.count += near ? one : zero;
    sums.sum[0] += dx, sums.sum[1] += dy, sums.sum[2] += dz;
    sums.cross[0] += dx * dx, sums.cross[1] += dx * dy, sums.cross[2] += dx * dz;
    sums.cross[3] += dy * dy, sums.cross[4] += dy * dz, sums.cross[5] += dz * dz;
  }
  out = sums;
}

}  // namespace

Neighbourhoods NeighbourSearch::neighbourhoods(const Leaf& leaf, int neighbours,
                                               std::vector<Point>& memory) const {
  Neighbourhoods out = {};
  if (leaf.index[0] < 0) return out;
  memory.clear();
  memory.reserve(size_);
  // Lanes without a point are the first one's copies.
  Floats queries[3] = {leaf.x, leaf.y, leaf.z};
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    Floats& values = queries[axis];
    box.low[axis] = box.high[axis] = values[0];
    for (int i = 1; i < kLanes; ++i) {
      if (leaf.index[i] < 0) values[i] = values[0];
      box.low[axis] = std::min(box.low[axis], values[i]);
      box.high[axis] = std::max(box.high[axis], values[i]);
    }
  }
  FoundNeighbours found{.queries = queries, .box = box, .wanted = neighbours, .candidates = memory};
  for (int k = 0; k < neighbours; ++k) found.squares[k] = Floats{} + kEverywhere;
  sum_neighbours(splits_.data(), splits_.size(), leaves_.data(), found, out);
  for (int i = 0; i < kLanes; ++i) {
    if (leaf.index[i] < 0) out.count[i] = 0;
  }
  return out;
}

}  // namespace infuse::features

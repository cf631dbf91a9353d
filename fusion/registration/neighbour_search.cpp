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

/// Nearest point of one, and the distance within which there is no other.
struct FoundNearest {
  const float* point;
  float best, second;  // squared
  float margin;
  float limit;  // squared: what is farther away need not be visited
  int32_t index = -1;

  [[gnu::always_inline]] float bound() const { return limit; }
  [[gnu::always_inline]] void add(const NeighbourSearch::Leaf& leaf) {
    const Floats dx = leaf.x - point[0], dy = leaf.y - point[1], dz = leaf.z - point[2];
    const Floats square = dx * dx + dy * dy + dz * dz;
    if (!(minimum(square) < limit)) return;
    for (int i = 0; i < kLanes; ++i) {
      if (!(square[i] < second)) continue;
      if (square[i] < best) {
        second = best;
        best = square[i];
        index = leaf.index[i];
      } else {
        second = square[i];
      }
    }
    const float reach = std::sqrt(best) + margin;
    limit = std::min(second, reach * reach);
  }
};

/// The same of each of 16 points.
struct FoundOfEach {
  const NearestQueries& queries;
  const Box& box;
  float margin;
  Floats best, second, limits;  // squared
  Ints index;
  float limit;

  [[gnu::always_inline]] float bound() const { return limit; }
  [[gnu::always_inline]] void add(const NeighbourSearch::Leaf& leaf) {
    const Floats from_box = square_distances(leaf, box);
    for (int i = 0; i < kLanes; ++i) {
      if (!(from_box[i] < limit)) continue;
      const Floats dx = leaf.x[i] - queries.at[0], dy = leaf.y[i] - queries.at[1],
                   dz = leaf.z[i] - queries.at[2];
      const Floats square = dx * dx + dy * dy + dz * dz;
      const Flags nearest = square < best;
      const Floats farther = nearest ? best : square;
      second = farther < second ? farther : second;
      best = nearest ? square : best;
      index = nearest ? Flags{} + leaf.index[i] : index;
    }
    Floats reach;
    for (int i = 0; i < kLanes; ++i) reach[i] = std::sqrt(best[i]);
    reach += margin;
    reach *= reach;
    limits = second < reach ? second : reach;
    limit = maximum(queries.max_distance < 0 ? Floats{} - 1 : limits);
  }
};

INFUSE_SIMD_CLONES void find_nearest(const NeighbourSearch::Split* splits, size_t inner_nodes,
                                     const NeighbourSearch::Leaf* leaves, const Box& box,
                                     FoundNearest& found) {
  FoundNearest local = found;
  visit(splits, inner_nodes, leaves, box, local);
  found = local;
}

INFUSE_SIMD_CLONES void find_nearest_of_each(const NeighbourSearch::Split* splits,
                                             size_t inner_nodes,
                                             const NeighbourSearch::Leaf* leaves, const Box& box,
                                             FoundOfEach& found) {
  visit(splits, inner_nodes, leaves, box, found);
}

/// The squared distances of the nearest points of each of 16 points, sorted, and the points among
/// which they are.
struct FoundNeighbours {
  const Floats* queries;  // x, y, z
  const Box& box;
  int wanted;
  std::vector<NeighbourSearch::Point>& candidates;
  Floats squares[NeighbourSearch::kMaxNeighbours];
  float limit = kInfinity;

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

void NeighbourSearch::build_and_sort(PointCloud& cloud) {
  build(cloud.points());
  cloud.resize(size_);
  for (size_t i = 0; i < size_; ++i) {
    cloud.x[i] = entries_[i].at[0], cloud.y[i] = entries_[i].at[1], cloud.z[i] = entries_[i].at[2];
    cloud.nx[i] = cloud.ny[i] = cloud.nz[i] = 0;
  }
  int32_t next = 0;
  for (Leaf& leaf : leaves_) {
    for (int32_t& index : leaf.index) index = index < 0 ? index : next++;
  }
}

void NeighbourSearch::build_node(size_t node, size_t begin, size_t end) {
  const auto at = [&](size_t i) { return entries_.begin() + static_cast<ptrdiff_t>(i); };
  if (node >= splits_.size()) {
    Leaf& leaf = leaves_[node - splits_.size()];
    // Standard libraries partition in different orders.
    std::sort(at(begin), at(end), [](const Entry& a, const Entry& b) { return a.index < b.index; });
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
  const Box box{{point[0], point[1], point[2]}, {point[0], point[1], point[2]}};
  FoundNearest found{point, reach * reach, reach * reach, margin, reach * reach, -1};
  find_nearest(splits_.data(), splits_.size(), leaves_.data(), box, found);
  const bool near = found.index >= 0 && found.best <= max_distance * max_distance;
  if (!near) return {-1, 0, found.index >= 0 ? std::sqrt(found.best) : reach};
  return {found.index, found.best, std::sqrt(found.limit)};
}

NearestOfEach NeighbourSearch::nearest_of_each(const NearestQueries& queries, float margin) const {
  NearestOfEach out{Flags{} - 1, {}, {}};
  if (size_ == 0) return out;
  Box box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < kLanes; ++i) {
      if (queries.max_distance[i] < 0) continue;
      box.low[axis] = std::min(box.low[axis], queries.at[axis][i]);
      box.high[axis] = std::max(box.high[axis], queries.at[axis][i]);
    }
  }
  const Floats reach = queries.max_distance + margin, square = reach * reach;
  FoundOfEach found{queries, box, margin, square, square, square, Flags{} - 1, maximum(square)};
  find_nearest_of_each(splits_.data(), splits_.size(), leaves_.data(), box, found);
  for (int i = 0; i < kLanes; ++i) {
    const float distance = std::sqrt(found.best[i]);
    const bool near = found.index[i] >= 0 && distance <= queries.max_distance[i];
    out.index[i] = near ? found.index[i] : -1;
    out.square_distance[i] = found.best[i];
    out.others[i] = near ? std::sqrt(found.limits[i]) : distance;
  }
  return out;
}

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
  for (int k = 0; k < neighbours; ++k) found.squares[k] = Floats{} + kInfinity;
  sum_neighbours(splits_.data(), splits_.size(), leaves_.data(), found, out);
  for (int i = 0; i < kLanes; ++i) {
    if (leaf.index[i] < 0) out.count[i] = 0;
  }
  return out;
}

}  // namespace infuse::registration

#include "fusion/features/neighbour_search.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "drivers/measurement/simd.hpp"
#include "fusion/features/neighbour_visit.hpp"

namespace infuse::features {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

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

/// The nearest points of one, sorted.
struct FoundPoints {
  const float* point;
  std::span<int32_t> indices;
  std::span<float> squares;
  float limit;  // squared
  size_t count = 0;

  [[gnu::always_inline]] float bound() const { return limit; }
  [[gnu::always_inline]] void add(const NeighbourSearch::Leaf& leaf) {
    const Floats dx = leaf.x - point[0], dy = leaf.y - point[1], dz = leaf.z - point[2];
    const Floats square = dx * dx + dy * dy + dz * dz;
    if (!(minimum(square) < limit)) return;
    for (int i = 0; i < kLanes; ++i) {
      if (!(square[i] < limit)) continue;
      size_t at = count < indices.size() ? count++ : count - 1;
      for (; at > 0 && squares[at - 1] > square[i]; --at) {
        squares[at] = squares[at - 1];
        indices[at] = indices[at - 1];
      }
      squares[at] = square[i];
      indices[at] = leaf.index[i];
      if (count == indices.size()) limit = squares.back();
    }
  }
};

INFUSE_SIMD_CLONES void find_points(const NeighbourSearch::Split* splits, size_t inner_nodes,
                                    const NeighbourSearch::Leaf* leaves, const Box& box,
                                    FoundPoints& found) {
  visit(splits, inner_nodes, leaves, box, found);
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

void NeighbourSearch::build_and_sort(FieldVector<float>& x, FieldVector<float>& y,
                                     FieldVector<float>& z) {
  build({x, y, z});
  for (FieldVector<float>* field : {&x, &y, &z}) field->resize(size_);
  for (size_t i = 0; i < size_; ++i) {
    x[i] = entries_[i].at[0], y[i] = entries_[i].at[1], z[i] = entries_[i].at[2];
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

size_t NeighbourSearch::nearest_points(const float* point, float max_square,
                                       std::span<int32_t> indices, std::span<float> squares) const {
  if (size_ == 0) return 0;
  const Box box{{point[0], point[1], point[2]}, {point[0], point[1], point[2]}};
  FoundPoints found{point, indices, squares, max_square};
  find_points(splits_.data(), splits_.size(), leaves_.data(), box, found);
  return found.count;
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

}  // namespace infuse::features

#include "fusion/features/image_edges.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/measurement/simd.hpp"

namespace infuse::features {
namespace {

/// |n · ∇I| of a row, of which there is one more sample on both sides; `right` and `down`: n.
INFUSE_SIMD_CLONES void ring_edge_row(const float* __restrict above, const float* __restrict here,
                                      const float* __restrict below, const float* __restrict right,
                                      const float* __restrict down, int samples,
                                      float* __restrict out) {
  for (int u = 0; u < samples; ++u) {
    const float across =
        above[u + 1] - above[u - 1] + 2 * (here[u + 1] - here[u - 1]) + below[u + 1] - below[u - 1];
    const float downwards =
        below[u - 1] - above[u - 1] + 2 * (below[u] - above[u]) + below[u + 1] - above[u + 1];
    out[u] = 0.25F * std::abs(right[u] * across + down[u] * downwards);
  }
}

/// A row with its first and last sample once more.
void copy_with_border(const Plane& plane, int v, std::vector<float>& out) {
  const float* from = plane.row(v);
  out.resize(static_cast<size_t>(plane.width) + 2);
  out.front() = from[0];
  std::copy_n(from, plane.width, out.begin() + 1);
  out.back() = from[plane.width - 1];
}

/// Values of the cells of row `v`, one a sample; beyond the cells those of the last.
void expand_cells(const RingDirections& rings, const std::vector<float>& values, int v,
                  std::vector<float>& out) {
  const int first = std::min(v / RingDirections::kCellSize, rings.rows - 1) * rings.columns;
  for (size_t u = 0; u < out.size(); ++u) {
    const int column = std::min(static_cast<int>(u) / RingDirections::kCellSize, rings.columns - 1);
    out[u] = values[static_cast<size_t>(first + column)];
  }
}

}  // namespace

Plane edge_strength(const Plane& grey) {
  Plane edge;
  edge.resize_like(grey);
  const int width = grey.width;
  std::vector<float> high(static_cast<size_t>(width));
  std::vector<float> low(static_cast<size_t>(width));
  for (int v = 0; v < grey.height; ++v) {
    const float* above = grey.row(v - 1);
    const float* here = grey.row(v);
    const float* below = grey.row(v + 1);
    for (int u = 0; u < width; ++u) {
      const auto at = static_cast<size_t>(u);
      high[at] = std::max(std::max(above[u], here[u]), below[u]);
      low[at] = std::min(std::min(above[u], here[u]), below[u]);
    }
    float* out = edge.row(v);
    for (int u = 0; u < width; ++u) {
      const auto left = static_cast<size_t>(std::max(u - 1, 0));
      const auto at = static_cast<size_t>(u);
      const auto right = static_cast<size_t>(std::min(u + 1, width - 1));
      const float highest = std::max(std::max(high[left], high[at]), high[right]);
      const float lowest = std::min(std::min(low[left], low[at]), low[right]);
      out[u] = std::max(highest - here[u], here[u] - lowest);
    }
  }
  return edge;
}

void RingEdge::compute(const Plane& grey, const RingDirections& rings, Plane& out) {
  out.resize_like(grey);
  const auto width = static_cast<size_t>(grey.width);
  right_.assign(width, 1.0F);
  down_.assign(width, 0.0F);
  for (int v = 0; v < grey.height; ++v) {
    if (rings.columns > 0 && v % RingDirections::kCellSize == 0) {
      expand_cells(rings, rings.right, v, right_);
      expand_cells(rings, rings.down, v, down_);
    }
    copy_with_border(grey, v - 1, above_);
    copy_with_border(grey, v, here_);
    copy_with_border(grey, v + 1, below_);
    ring_edge_row(above_.data() + 1, here_.data() + 1, below_.data() + 1, right_.data(),
                  down_.data(), grey.width, out.row(v));
  }
}

Plane ring_edge(const Plane& grey, const RingDirections& rings) {
  Plane edge;
  RingEdge().compute(grey, rings, edge);
  return edge;
}

}  // namespace infuse::features

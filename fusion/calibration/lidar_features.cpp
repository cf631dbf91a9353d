#include "fusion/calibration/lidar_features.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

namespace infuse::calibration {
namespace {

/// Indices of the returns ordered by ring, and within a ring as they were fired.
std::vector<uint32_t> order_by_ring(const Sweep& sweep) {
  std::vector<uint32_t> order(sweep.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto earlier = [&](uint32_t a, uint32_t b) { return sweep.ring[a] < sweep.ring[b]; };
  if (!std::is_sorted(order.begin(), order.end(), earlier)) {
    std::stable_sort(order.begin(), order.end(), earlier);
  }
  return order;
}

/// The azimuths of two returns lie within a gap whose tangent is given (below 90°).
bool within_azimuth(const Sweep& sweep, uint32_t a, uint32_t b, double tangent) {
  const double cross = double{sweep.x[a]} * sweep.y[b] - double{sweep.y[a]} * sweep.x[b];
  const double dot = double{sweep.x[a]} * sweep.x[b] + double{sweep.y[a]} * sweep.y[b];
  return dot > 0 && std::abs(cross) <= tangent * dot;
}

/// Which returns lie within reach of an edge on their ring.
std::vector<uint8_t> near_edges(const Sweep& sweep, const std::vector<uint32_t>& order,
                                const std::vector<double>& step,
                                const DiscontinuityOptions& options) {
  std::vector<uint8_t> near(sweep.size(), 0);
  const double tangent = std::tan(options.max_edge_azimuth);
  const auto mark = [&](auto first, auto last) {
    std::optional<uint32_t> edge;
    for (; first != last; ++first) {
      if (step[*first] >= options.min_edge_step) edge = *first;
      if (!edge || sweep.ring[*edge] != sweep.ring[*first]) continue;
      if (within_azimuth(sweep, *first, *edge, tangent)) near[*first] = 1;
    }
  };
  mark(order.begin(), order.end());
  mark(order.rbegin(), order.rend());
  return near;
}

}  // namespace

std::optional<std::string> DiscontinuityOptions::invalid() const {
  if (!(gamma > 0) || !(gamma <= 2)) return "gamma must lie in (0, 2]";
  if (!(max_gap > 0) || !(max_gap < 1.5)) return "max_gap must lie in (0, 1.5)";
  if (!(no_return_step >= 0)) return "no_return_step must not be negative";
  if (!(max_edge_azimuth >= 0) || !(max_edge_azimuth < 1.5)) return "reach must lie in [0, 1.5)";
  if (!(min_edge_step > 0)) return "min_edge_step must be positive";
  return std::nullopt;
}

std::vector<float> discontinuity(const Sweep& sweep, const DiscontinuityOptions& options) {
  const std::vector<uint32_t> order = order_by_ring(sweep);
  std::vector<double> step(sweep.size(), 0.0);
  const double tangent = std::tan(options.max_gap);
  // The step from `i` to its neighbour `j`, or to nothing where there is none.
  const auto update_step = [&](uint32_t i, const uint32_t* j) {
    const bool near =
        j != nullptr && sweep.ring[*j] == sweep.ring[i] && within_azimuth(sweep, i, *j, tangent);
    step[i] =
        std::max(step[i], near ? double{sweep.range[*j]} - sweep.range[i] : options.no_return_step);
  };
  const auto same_firing = [&](uint32_t i, uint32_t j) {
    return sweep.ring[i] == sweep.ring[j] && sweep.column[i] == sweep.column[j];
  };
  for (size_t at = 0; at < order.size(); ++at) {
    size_t before = at;
    while (before > 0 && same_firing(order[at], order[before - 1])) --before;
    size_t after = at + 1;
    while (after < order.size() && same_firing(order[at], order[after])) ++after;
    update_step(order[at], before > 0 ? &order[before - 1] : nullptr);
    update_step(order[at], after < order.size() ? &order[after] : nullptr);
  }
  std::vector<float> edge(sweep.size(), 0.0F);
  for (size_t i = 0; i < edge.size(); ++i) {
    if (step[i] > 0) edge[i] = static_cast<float>(std::pow(step[i], options.gamma));
  }
  if (options.max_edge_azimuth > 0) {
    const std::vector<uint8_t> near = near_edges(sweep, order, step, options);
    for (size_t i = 0; i < edge.size(); ++i) {
      if (near[i] == 0) edge[i] = kNotCompared;
    }
  }
  return edge;
}

namespace {

/// A value and where it stood.
struct Keyed {
  uint32_t key;  ///< sorts as the float does
  uint32_t index;
};

uint32_t sort_key(float value) {
  const auto bits = std::bit_cast<uint32_t>(value + 0.0F);  // −0 becomes 0
  return (bits & 0x8000'0000U) != 0 ? ~bits : bits | 0x8000'0000U;
}

/// Radix sort, eleven bits at a time.
void sort_by_key(std::vector<Keyed>& keyed) {
  std::vector<Keyed> other(keyed.size());
  for (const int shift : {0, 11, 22}) {
    std::array<uint32_t, 2049> first{};
    const auto digit = [&](const Keyed& k) { return (k.key >> shift) & 2047U; };
    for (const Keyed& k : keyed) ++first[digit(k) + 1];
    for (size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
    for (const Keyed& k : keyed) other[first[digit(k)]++] = k;
    keyed.swap(other);
  }
}

/// Ranks of values that stand in order, divided by their number.
void assign_ranks(std::span<const Keyed> keyed, std::span<float> values) {
  const auto n = static_cast<double>(keyed.size());
  for (size_t first = 0; first < keyed.size();) {
    size_t last = first;
    while (last < keyed.size() && keyed[last].key == keyed[first].key) ++last;
    const auto shared = static_cast<float>(0.5 * static_cast<double>(first + last - 1) / n);
    for (size_t i = first; i < last; ++i) values[keyed[i].index] = shared;
    first = last;
  }
}

}  // namespace

void equalize(std::span<float> values) {
  std::vector<Keyed> keyed(values.size());
  for (size_t i = 0; i < values.size(); ++i)
    keyed[i] = {sort_key(values[i]), static_cast<uint32_t>(i)};
  sort_by_key(keyed);
  assign_ranks(keyed, values);
}

std::vector<float> relative_discontinuity(std::span<const uint16_t> ring,
                                          std::span<const float> discontinuity) {
  std::vector<Keyed> keyed;
  for (size_t i = 0; i < discontinuity.size(); ++i) {
    if (std::isnan(discontinuity[i])) continue;
    keyed.push_back({sort_key(discontinuity[i]), static_cast<uint32_t>(i)});
  }
  sort_by_key(keyed);
  std::stable_sort(keyed.begin(), keyed.end(),
                   [&](const Keyed& a, const Keyed& b) { return ring[a.index] < ring[b.index]; });
  std::vector<float> relative(discontinuity.begin(), discontinuity.end());
  const std::span<const Keyed> all(keyed);
  for (size_t first = 0; first < all.size();) {
    size_t last = first;
    while (last < all.size() && ring[all[last].index] == ring[all[first].index]) ++last;
    assign_ranks(all.subspan(first, last - first), relative);
    first = last;
  }
  return relative;
}

}  // namespace infuse::calibration

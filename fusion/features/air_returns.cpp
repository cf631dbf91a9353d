#include "fusion/features/air_returns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace infuse::features {

std::optional<std::string> AirReturnOptions::invalid() const {
  if (!(max_range > 0)) return "max_range must be positive";
  if (columns < 1 || columns > 100) return "columns must be between 1 and 100";
  if (!(tolerance > 0 && slope >= 0)) return "tolerance and slope must be positive";
  if (min_neighbours < 1 || min_neighbours > 2 * columns)
    return "min_neighbours must be between 1 and 2 · columns";
  if (!(min_share >= 0 && min_share <= 1)) return "min_share must be between 0 and 1";
  return std::nullopt;
}

void AirReturns::sort_by_ring(const Sweep& sweep) {
  // Neighbours may be a little beyond the range.
  const auto reach = static_cast<float>(2 * options_.max_range);
  ring_begin_.assign(size_t{sweep.rings} + 1, 0);
  const auto is_near = [&](size_t i) {
    return sweep.range[i] <= reach && sweep.ring[i] < sweep.rings;
  };
  for (size_t i = 0; i < sweep.size(); ++i) {
    if (is_near(i)) ++ring_begin_[sweep.ring[i] + size_t{1}];
  }
  for (size_t ring = 0; ring < sweep.rings; ++ring) ring_begin_[ring + 1] += ring_begin_[ring];
  order_.reserve(sweep.size());
  neighbours_.reserve(sweep.size());
  order_.resize(ring_begin_.back());
  for (size_t i = 0; i < sweep.size(); ++i) {
    if (is_near(i)) order_[ring_begin_[sweep.ring[i]]++] = static_cast<uint32_t>(i);
  }
  // Every begin has moved to the next ring's.
  std::rotate(ring_begin_.begin(), ring_begin_.end() - 1, ring_begin_.end());
  ring_begin_.front() = 0;
}

void AirReturns::count_neighbours(const Sweep& sweep) {
  const auto tolerance = static_cast<float>(options_.tolerance);
  const auto slope = static_cast<float>(options_.slope);
  const auto reach = static_cast<size_t>(options_.columns);
  neighbours_.assign(order_.size(), 0);
  for (size_t ring = 0; ring < sweep.rings; ++ring) {
    for (size_t a = ring_begin_[ring]; a < ring_begin_[ring + 1]; ++a) {
      const uint32_t i = order_[a];
      // A firing has two returns at most.
      const size_t end = std::min<size_t>(ring_begin_[ring + 1], a + 2 * (reach + 1));
      for (size_t b = a + 1; b < end; ++b) {
        const uint32_t j = order_[b];
        const int columns = sweep.column[j] - sweep.column[i];
        if (columns > options_.columns) break;
        if (columns <= 0) continue;  // two echoes of one pulse
        const float across = std::abs(sweep.x[i] * sweep.y[j] - sweep.y[i] * sweep.x[j]) /
                             std::max(sweep.range[i], sweep.range[j]);
        if (std::abs(sweep.range[i] - sweep.range[j]) > tolerance + slope * across) continue;
        ++neighbours_[a];
        ++neighbours_[b];
      }
    }
  }
}

size_t AirReturns::find(const Sweep& sweep) {
  found_.clear();
  if (sweep.rings == 0 || sweep.columns == 0) return 0;
  sort_by_ring(sweep);
  count_neighbours(sweep);
  const auto max_range = static_cast<float>(options_.max_range);
  found_.reserve(sweep.size());
  size_t near = 0;
  for (size_t k = 0; k < order_.size(); ++k) {
    if (!(sweep.range[order_[k]] <= max_range)) continue;
    ++near;
    if (neighbours_[k] < options_.min_neighbours) found_.push_back(order_[k]);
  }
  if (static_cast<double>(found_.size()) < options_.min_share * static_cast<double>(near)) {
    found_.clear();
  }
  return found_.size();
}

void AirReturns::leave_out(std::span<float> x) const {
  for (const uint32_t i : found_) x[i] = std::numeric_limits<float>::quiet_NaN();
}

std::span<const float> AirReturns::without(std::span<const float> x) {
  if (found_.empty()) return x;
  x_.assign(x.begin(), x.end());
  leave_out(x_);
  return x_;
}

}  // namespace infuse::features

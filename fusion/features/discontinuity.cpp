#include "fusion/features/discontinuity.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "fusion/features/ranks.hpp"

namespace infuse::features {
namespace {

/// True if the azimuths of two returns differ by less than the angle of this tangent (below 90°).
bool within_azimuth(const SweepView& sweep, uint32_t a, uint32_t b, float tangent) {
  const float ax = sweep.points.x[a], ay = sweep.points.y[a];
  const float bx = sweep.points.x[b], by = sweep.points.y[b];
  const float dot = ax * bx + ay * by;
  return dot > 0 && std::abs(ax * by - ay * bx) <= tangent * dot;
}

}  // namespace

std::optional<std::string> DiscontinuityOptions::invalid() const {
  if (!(gamma > 0) || !(gamma <= 2)) return "gamma must be between 0 and 2";
  if (!(max_gap > 0) || !(max_gap < 1.5)) return "max_gap must be between 0 and 1.5";
  if (max_column_gap < 0) return "max_column_gap must not be negative";
  if (!(no_return_step >= 0)) return "no_return_step must not be negative";
  if (!(max_step > 0)) return "max_step must be positive";
  if (!(max_edge_azimuth >= 0) || !(max_edge_azimuth < 1.5))
    return "max_edge_azimuth must be between 0 and 1.5";
  if (!(min_edge_step > 0)) return "min_edge_step must be positive";
  return std::nullopt;
}

Discontinuity::Discontinuity(const DiscontinuityOptions& options)
    : options_(options), gap_tangent_(static_cast<float>(std::tan(options.max_gap))) {}

/// Step from return `i` to its neighbour, which may be missing.
void Discontinuity::update_step(const SweepView& sweep, uint32_t i, uint32_t neighbour) {
  const auto is_near = [&] {
    const int columns =
        neighbour == kNone ? 0 : std::abs(sweep.column[neighbour] - sweep.column[i]);
    if (options_.max_column_gap > 0 && columns > options_.max_column_gap) return false;
    return within_azimuth(sweep, i, neighbour, gap_tangent_);
  };
  const float step = neighbour != kNone && is_near() ? sweep.range[neighbour] - sweep.range[i]
                                                     : static_cast<float>(options_.no_return_step);
  values_[i] = std::max(values_[i], step);
}

void Discontinuity::find_steps(const SweepView& sweep) {
  const auto n = static_cast<uint32_t>(sweep.size());
  values_.assign(n, 0.0F);
  same_firing_.resize(n);
  std::fill(rings_.begin(), rings_.end(), Ring{});
  const auto update_firing = [&](uint32_t last, uint32_t neighbour) {
    for (uint32_t k = last; k != kNone; k = same_firing_[k]) update_step(sweep, k, neighbour);
  };
  for (uint32_t i = 0; i < n; ++i) {
    if (sweep.ring[i] >= rings_.size()) rings_.resize(sweep.ring[i] + size_t{1});
    Ring& ring = rings_[sweep.ring[i]];
    const bool same = ring.last != kNone && sweep.column[ring.last] == sweep.column[i];
    same_firing_[i] = same ? ring.last : kNone;
    if (!same) {
      update_firing(ring.last, i);
      ring.previous_firing = ring.last;
    }
    update_step(sweep, i, ring.previous_firing);
    ring.last = i;
  }
  if (options_.no_return_step > 0) {
    for (const Ring& ring : rings_) update_firing(ring.last, kNone);
  }
}

/// Marks the returns within reach of an edge on their ring, before or after them.
void Discontinuity::mark_near_edges(const SweepView& sweep) {
  near_edge_.assign(sweep.size(), 0);
  const auto tangent = static_cast<float>(std::tan(options_.max_edge_azimuth));
  const auto min_step = static_cast<float>(options_.min_edge_step);
  const auto mark = [&](size_t at) {
    const auto i = static_cast<uint32_t>(at);
    uint32_t& edge = rings_[sweep.ring[i]].last;
    if (values_[i] >= min_step) edge = i;
    if (edge != kNone && within_azimuth(sweep, i, edge, tangent)) near_edge_[i] = 1;
  };
  std::fill(rings_.begin(), rings_.end(), Ring{});
  for (size_t i = 0; i < sweep.size(); ++i) mark(i);
  std::fill(rings_.begin(), rings_.end(), Ring{});
  for (size_t i = sweep.size(); i-- > 0;) mark(i);
}

const std::vector<float>& Discontinuity::compute(const SweepView& sweep) {
  find_steps(sweep);
  const bool masked = options_.max_edge_azimuth > 0;
  if (masked) mark_near_edges(sweep);
  const auto max_step = static_cast<float>(options_.max_step);
  const auto gamma = static_cast<float>(options_.gamma);
  for (size_t i = 0; i < values_.size(); ++i) {
    const float step = std::min(values_[i], max_step);
    if (masked && near_edge_[i] == 0) {
      values_[i] = kNotCompared;
    } else {
      values_[i] = gamma == 0.5F ? std::sqrt(step) : std::pow(step, gamma);
    }
  }
  return values_;
}

std::vector<float> relative_discontinuity(std::span<const uint16_t> ring,
                                          std::span<const float> discontinuity) {
  std::vector<float> relative(discontinuity.begin(), discontinuity.end());
  equalize_within_groups(ring, relative);
  return relative;
}

}  // namespace infuse::features

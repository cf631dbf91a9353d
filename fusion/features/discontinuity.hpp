#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/features/sweep_view.hpp"

namespace infuse::features {

/// Value of a feature for returns that are left out of the comparison.
inline constexpr float kNotCompared = std::numeric_limits<float>::quiet_NaN();

/// Settings of the scan discontinuity.
struct DiscontinuityOptions {
  double gamma = 0.5;         ///< exponent, I 4.3.1.2
  double max_gap = 0.02;      ///< rad of azimuth between neighbours; four firings of a slow HDL-32E
  int max_column_gap = 0;     ///< columns between neighbours; 0: no limit
  double no_return_step = 0;  ///< m; step towards a neighbour that is missing; 0: none
  double max_step = 1e3;      ///< m, above the range of any data sheet; larger steps count as this
  double max_edge_azimuth = 0.03;  ///< rad of azimuth to the nearest edge on the ring; returns
                                   ///< farther away become `kNotCompared`; 0: all are compared
  double min_edge_step = 0.5;      ///< m; smallest step of an edge, for `max_edge_azimuth`

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Scan discontinuity of returns, after Levinson and Thrun, I(3.6) and I 4.3.1.2:
///   e_i = max(d_{i−1} − d_i, d_{i+1} − d_i, 0)^γ
/// over the neighbours on the return's own ring. It marks the near side of a depth edge, where the
/// image has its edge too. (I prints the difference without its sign; "closer points" in the
/// explanation decides.)
///
/// A neighbour belongs to the previous or next firing on the ring, within `max_gap`: dual returns
/// of one firing are not neighbours. Where nothing came back (sky), the neighbour is missing.
///
/// Only returns near an edge are compared. The road has neither depth edges nor, mostly, image
/// edges, and fills the lower rows of the image: compared over all returns, the measure separates
/// road from houses instead of edges from surfaces, and rises as that border is moved (by several
/// degrees in a simulated garage).
///
/// Allocates nothing after its first sweep of a size.
class Discontinuity {
 public:
  /// `options.invalid()` must be empty.
  explicit Discontinuity(const DiscontinuityOptions& options = {});

  /// Returns one value per return, m^γ, never negative, or `kNotCompared`. Valid until the next
  /// call.
  const std::vector<float>& compute(const SweepView& sweep);

 private:
  static constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
  /// Returns of a ring seen last.
  struct Ring {
    uint32_t last = kNone;
    uint32_t previous_firing = kNone;  ///< last return of the firing before that of `last`
  };

  void find_steps(const SweepView& sweep);
  void update_step(const SweepView& sweep, uint32_t i, uint32_t neighbour);
  void mark_near_edges(const SweepView& sweep);

  DiscontinuityOptions options_;
  float gap_tangent_;
  std::vector<float> values_;
  std::vector<uint32_t> same_firing_;  ///< the return before, of the same firing
  std::vector<uint8_t> near_edge_;
  std::vector<Ring> rings_;
};

/// Discontinuity of every return as its rank among the compared returns of its own ring, 0 … 1;
/// equal values share the mean of their ranks; others stay `kNotCompared`. One entry a return in
/// both arguments.
///
/// Crowns stand above trunks, fences below windows: the size of steps depends on their height in
/// the image, and so does the strength of image edges. Compared over all rings, the measure rises
/// as one is moved along the other, by a degree before a wood.
std::vector<float> relative_discontinuity(std::span<const uint16_t> ring,
                                          std::span<const float> discontinuity);

}  // namespace infuse::features

#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/sweep.hpp"

namespace infuse::calibration {

/// A feature's value for returns that do not take part in what is compared.
inline constexpr float kNotCompared = std::numeric_limits<float>::quiet_NaN();

/// Scan discontinuity of every return, after Levinson and Thrun, I(3.6) and I 4.3.1.2:
///   e_i = max(d_{i−1} − d_i, d_{i+1} − d_i, 0)^γ
/// over the neighbours on the return's own ring, so that it marks the near side of a depth edge:
/// there the image has its edge too. The text of I prints the difference without saying which side
/// is which; "closer points" of its explanation decides.
///
/// A neighbour is the return before or after on the same ring, if it lies within `max_gap`. Beyond
/// it nothing came back (sky), and the neighbour counts as `no_return_step` farther away.
///
/// The road has neither depth edges nor, mostly, image edges, and the picture's rows go with it:
/// compared over all returns, the measure tells road from houses rather than edges from none, and
/// rises as that border is moved (by several degrees in a simulated garage). So an edge is compared
/// with what lies beside it alone.
struct DiscontinuityOptions {
  double gamma = 0.5;         ///< exponent, I 4.3.1.2
  double max_gap = 0.02;      ///< rad of azimuth between neighbours; four firings of a slow HDL-32E
  double no_return_step = 0;  ///< m; the step that a missing neighbour stands for, 0: none
  double max_edge_azimuth = 0.03;  ///< rad of azimuth; returns farther than that from any edge on
                                   ///< their ring are not compared (`kNotCompared`); 0: all are
  double min_edge_step = 0.5;  ///< m; the step that makes an edge, for `reach`

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// One value a return of `sweep`, m^γ, never negative, or `kNotCompared`. Needs `ring` and
/// `column`; dual returns of one firing are no neighbours of each other.
std::vector<float> discontinuity(const Sweep& sweep, const DiscontinuityOptions& options);

/// Every return's discontinuity by rank among those of its own ring that are compared, 0 … 1; equal
/// values share the mean of their ranks; the others stay `kNotCompared`. One entry a return in
/// both.
///
/// Crowns stand above trunks, fences below windows: how large the steps of a picture's rows are
/// goes with their height, and so do the picture's edges. Compared over all rings, the measure
/// rises as one is moved along the other, by a degree before a wood.
std::vector<float> relative_discontinuity(std::span<const uint16_t> ring,
                                          std::span<const float> discontinuity);

/// Replaces every value by its rank among all, divided by their number: 0 ≤ … < 1, equal values
/// share the mean of their ranks. A histogram over ranks is evenly filled whatever the sensor's
/// response, and a monotone change of that response changes nothing.
void equalize(std::span<float> values);

}  // namespace infuse::calibration

#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/sweep.hpp"

namespace infuse::features {

/// Settings of the search for returns of the air, chosen on two towns (decision 13).
struct AirReturnOptions {
  double max_range = 12;    ///< m; droplets farther away return too little to be measured
  int columns = 4;          ///< neighbours are at most so many firings before or after, …
  double tolerance = 0.06;  ///< m; … and differ in range by no more than this …
  double slope = 3;         ///< … plus so much per metre across the beam: of a slanting surface
  int min_neighbours = 3;   ///< with fewer a return stands alone
  /// Share of the near returns that stand alone; below it the air is clear and nothing is left out:
  /// thin poles and twigs stand alone too.
  double min_share = 0.06;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Finds the returns of fog, spray and snowflakes: near ones that stand alone on their ring. The
/// echoes of a surface lie at like ranges from one firing to the next; the air returns light from
/// anywhere in the first metres of a beam. Rings are not compared: their firings of one column may
/// have different azimuths.
///
/// Allocates nothing after its first sweep of a size.
class AirReturns {
 public:
  /// `options.invalid()` must be empty.
  explicit AirReturns(const AirReturnOptions& options = {}) : options_(options) {}

  /// Finds the returns of the air in a sweep, and returns how many there are; 0 in a sweep whose
  /// rings or columns are not known.
  size_t find(const Sweep& sweep);

  /// Sets those found last to NaN: `x` has one entry a return of that sweep.
  void leave_out(std::span<float> x) const;

  /// Returns `x` with those found last set to NaN. Valid until the next call.
  std::span<const float> without(std::span<const float> x);

 private:
  void sort_by_ring(const Sweep& sweep);
  void count_neighbours(const Sweep& sweep);

  AirReturnOptions options_;
  std::vector<uint32_t> order_;       // near returns by ring, then by firing
  std::vector<uint32_t> ring_begin_;  // in `order_`
  std::vector<uint16_t> neighbours_;  // by entry of `order_`
  std::vector<uint32_t> found_;       // returns of the air
  FieldVector<float> x_;
};

}  // namespace infuse::features

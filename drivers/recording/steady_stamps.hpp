#pragma once

#include <cstdint>
#include <optional>

#include "drivers/measurement/stamp.hpp"

namespace infuse::recording {

/// Lets a capture's stamps run on where the clock of the host that recorded it was set back.
/// Datagrams are out of order by milliseconds; a single odd stamp stays as it is.
class SteadyStamps {
 public:
  /// The stamp as if the clock had not been set back.
  Stamp steady(Stamp raw);

  /// Number of times that the clock was set back, and the largest step.
  uint64_t steps() const { return steps_; }
  Duration largest() const { return largest_; }

 private:
  bool is_far_before(Stamp stamp, Stamp other) const { return stamp < other - kMaxDisorder; }

  static constexpr Duration kMaxDisorder{500'000'000};
  static constexpr Duration kMaxStep{86'400'000'000'000};  ///< beyond a day it is a bad stamp

  bool started_ = false;
  Stamp newest_, before_newest_;
  Duration shift_{0}, largest_{0};
  std::optional<Duration> undo_;  ///< the shift before a step that only one stamp shows so far
  uint64_t steps_ = 0;
};

}  // namespace infuse::recording

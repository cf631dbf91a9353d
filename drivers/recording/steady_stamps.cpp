#include "drivers/recording/steady_stamps.hpp"

#include <algorithm>
#include <utility>

namespace infuse::recording {

Stamp SteadyStamps::steady(Stamp raw) {
  Stamp stamp = raw + shift_;
  if (!std::exchange(started_, true)) return newest_ = before_newest_ = stamp;
  const auto before_step = std::exchange(undo_, std::nullopt);
  if (before_step && distance_between(raw + *before_step, newest_) < kMaxDisorder) {
    shift_ = *before_step;
    --steps_;
    stamp = raw + shift_;
  }
  // A stamp that is near the one before the newest shows that the newest was the odd one.
  const Duration back = newest_ - stamp;
  if (is_far_before(stamp, newest_) && is_far_before(stamp, before_newest_) && back < kMaxStep) {
    undo_ = shift_;
    shift_ += back;
    ++steps_;
    largest_ = std::max(largest_, back);
    return newest_;
  }
  if (is_far_before(stamp, newest_)) {
    newest_ = std::max(stamp, before_newest_);
  } else if (stamp > newest_) {
    before_newest_ = std::exchange(newest_, stamp);
  }
  return stamp;
}

}  // namespace infuse::recording

#pragma once

#include <array>
#include <atomic>
#include <utility>

namespace infuse::daemon {

/// The latest value of one thread, for one other. Neither waits, and the newest is never left out:
/// of three values the writer fills one, the reader has one, and they exchange them for the third.
template <class Value>
class LatestValue {
 public:
  /// The writer's: a value to fill in, whose memory was used before.
  Value& next() { return values_[writing_]; }
  /// Passes `next` on.
  void publish() {
    writing_ = shared_.exchange(writing_ | kFresh, std::memory_order_acq_rel) & ~kFresh;
  }

  /// The reader's: swaps the newest value into `out`; false if there is none that is new.
  bool take(Value& out) {
    if ((shared_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    reading_ = shared_.exchange(reading_, std::memory_order_acq_rel) & ~kFresh;
    std::swap(values_[reading_], out);
    return true;
  }

 private:
  static constexpr unsigned kFresh = 4;

  std::array<Value, 3> values_;
  unsigned writing_ = 0, reading_ = 1;
  std::atomic<unsigned> shared_ = 2;
};

}  // namespace infuse::daemon

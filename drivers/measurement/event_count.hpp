#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// Lets a thread sleep until another thread has changed something, without a lock (an event count
/// over a Linux futex). Several rings can share one, so that a thread waits for all of them at
/// once.
///
/// Rule: the state that the condition reads is written by sequentially consistent operations, and
/// the writer calls `notify` afterwards. No wake-up is lost: in the single order of those
/// operations either `notify` sees the waiter counted, or the waiter counts itself later and so
/// sees the change.
class EventCount {
 public:
  static constexpr Duration kNoTimeout = Duration::max();

  /// Sleeps until the condition holds or the timeout expires. Returns whether the condition holds.
  template <class Condition>
  bool wait(Condition condition, Duration timeout = kNoTimeout) {
    if (condition()) return true;
    const Deadline deadline = deadline_after(timeout);
    waiters_.fetch_add(1);
    bool holds = false;
    bool late = false;
    while (true) {
      const uint32_t epoch = epoch_.load();
      holds = condition();
      if (holds || late) break;
      late = !sleep(epoch, deadline);
    }
    waiters_.fetch_sub(1);
    return holds;
  }

  /// Wakes all waiting threads, which then evaluate their conditions again. Costs one load if no
  /// thread waits.
  void notify() {
    if (waiters_.load() != 0) wake();
  }

 private:
  using Deadline = std::chrono::steady_clock::time_point;
  static Deadline deadline_after(Duration timeout);
  /// Sleeps while the epoch is this one. False when the deadline has passed.
  bool sleep(uint32_t epoch, Deadline deadline);
  void wake();

  std::atomic<uint32_t> epoch_{0};
  std::atomic<uint32_t> waiters_{0};
};

}  // namespace infuse

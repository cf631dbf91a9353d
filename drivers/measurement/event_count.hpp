#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// Lets a thread sleep until another one has changed something, without a lock (an event count over
/// a Linux futex). Several rings can share one, so that a thread waits for whichever speaks first.
///
/// Rule: what the condition reads is written by sequentially consistent operations, and the writer
/// calls `notify` afterwards. Why no wake-up is lost: in the single order of those operations
/// either `notify` sees the waiter counted, or the waiter, counting itself, comes later and so sees
/// the change.
class EventCount {
 public:
  static constexpr Duration kNoTimeout = Duration::max();

  /// Sleeps until the condition holds or the time is over. Returns whether the condition holds.
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

  /// Wakes all who wait, so that they look again. Costs one load where nobody waits.
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

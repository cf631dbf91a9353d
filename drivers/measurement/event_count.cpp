#include "drivers/measurement/event_count.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <climits>
#include <ctime>

namespace infuse {

static_assert(sizeof(std::atomic<uint32_t>) == sizeof(uint32_t), "the futex word");

EventCount::Deadline EventCount::deadline_after(Duration timeout) {
  const Deadline now = std::chrono::steady_clock::now();
  return timeout > Deadline::max() - now ? Deadline::max() : now + timeout;
}

bool EventCount::sleep(uint32_t epoch, Deadline deadline) {
  timespec left{};
  timespec* limit = nullptr;
  if (deadline != Deadline::max()) {
    const Duration span = deadline - std::chrono::steady_clock::now();
    if (span <= Duration::zero()) return false;
    left.tv_sec = static_cast<time_t>(span.count() / 1'000'000'000);
    left.tv_nsec = static_cast<long>(span.count() % 1'000'000'000);
    limit = &left;
  }
  // The caller evaluates its condition again after every return: wake-up, changed epoch, signal
  // handler or timeout.
  syscall(SYS_futex, &epoch_, FUTEX_WAIT_PRIVATE, epoch, limit, nullptr, 0);
  return true;
}

void EventCount::wake() {
  epoch_.fetch_add(1);
  syscall(SYS_futex, &epoch_, FUTEX_WAKE_PRIVATE, INT_MAX, nullptr, nullptr, 0);
}

}  // namespace infuse

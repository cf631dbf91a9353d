#pragma once

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <deque>
#include <string>
#include <thread>

namespace infuse::vm {

/// The monotonic clock, ms.
inline long now_ms() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return time.tv_sec * 1000 + time.tv_nsec / 1'000'000;
}

/// For how long an emulated machine stood still because its host did not run it: no load inside
/// delays a thread of the highest real-time priority, and none delays the answer of the host's file
/// server.
class StandStill {
 public:
  /// Watches from now on. `host_file` is one that the guest does not keep a copy of.
  explicit StandStill(const std::string& host_file) {
    const long processors = sysconf(_SC_NPROCESSORS_ONLN);
    for (long i = 0; i < processors; ++i) {
      watch([i] { pin(static_cast<int>(i)); }, [] {});
    }
    watch([] {}, [host_file] { read(host_file); });
  }
  ~StandStill() { ending_ = true; }
  StandStill(const StandStill&) = delete;
  StandStill& operator=(const StandStill&) = delete;

  /// By the one of its processors that stood still for longest, or by the host's files, ms.
  long ms() const {
    long longest = 0;
    for (const Watch& watch : watches_) longest = std::max<long>(longest, watch.late_ms);
    return longest;
  }

 private:
  static constexpr long kPeriodMs = 10;
  static constexpr long kUsualMs = 5;  // of delay, and not counted

  struct Watch {
    std::atomic<long> late_ms = 0;
    std::jthread thread;
  };

  static void pin(int processor) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(processor, &set);
    sched_setaffinity(0, sizeof(set), &set);
  }

  static void read(const std::string& path) {
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    char byte = 0;
    static_cast<void>(!::read(file, &byte, 1));
    close(file);
  }

  template <class Prepare, class Ask>
  void watch(Prepare prepare, Ask ask) {
    Watch& watch = watches_.emplace_back();
    watch.thread = std::jthread([this, &watch, prepare, ask] {
      const sched_param highest{sched_get_priority_max(SCHED_FIFO)};
      sched_setscheduler(0, SCHED_FIFO, &highest);
      prepare();
      for (long before = now_ms(); !ending_;) {
        usleep(kPeriodMs * 1000);
        ask();
        const long now = now_ms();
        const long late = now - before - kPeriodMs;
        if (late > kUsualMs) watch.late_ms += late;
        before = now;
      }
    });
  }

  std::atomic<bool> ending_ = false;
  std::deque<Watch> watches_;  // its threads end first
};

}  // namespace infuse::vm

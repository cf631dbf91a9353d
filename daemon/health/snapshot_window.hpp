#pragma once

#include <array>
#include <cstddef>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// The counters of the last ticks, against which rates and losses are taken.
template <class Counters>
class SnapshotWindow {
 public:
  /// Counters at one tick.
  struct Snapshot {
    Stamp stamp;
    Counters counters;
  };

  /// Begins with counters of nothing.
  explicit SnapshotWindow(Stamp start) { restart_at(start, {}); }

  /// Forgets everything before `now`.
  void restart_at(Stamp now, const Counters& counters) {
    count_ = 1;
    snapshots_[0] = {now, counters};
  }

  /// Takes the counters at `now` and gives the oldest, of at most `kMaxTicks` before.
  Snapshot push(Stamp now, const Counters& counters) {
    const Snapshot oldest =
        snapshots_[count_ > kMaxTicks ? (count_ - kMaxTicks) % snapshots_.size() : 0];
    snapshots_[count_++ % snapshots_.size()] = {now, counters};
    return oldest;
  }

 private:
  static constexpr size_t kMaxTicks = 10;

  std::array<Snapshot, kMaxTicks + 1> snapshots_;
  size_t count_ = 0;
};

}  // namespace infuse::daemon

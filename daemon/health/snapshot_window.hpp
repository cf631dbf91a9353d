#pragma once

#include <array>
#include <cstddef>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Counters of the last ticks, the reference for rates and losses.
template <class Counters>
class SnapshotWindow {
 public:
  /// Counters at one tick.
  struct Snapshot {
    Stamp stamp;
    Counters counters;
  };

  /// Begins with zero counters at `start`.
  explicit SnapshotWindow(Stamp start) { restart_at(start, {}); }

  /// Discards everything before `now`.
  void restart_at(Stamp now, const Counters& counters) {
    count_ = 1;
    snapshots_[0] = {now, counters};
  }

  /// Adds the counters at `now` and returns the oldest, at most `kMaxTicks` ticks before.
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

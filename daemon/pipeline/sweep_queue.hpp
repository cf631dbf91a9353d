#pragma once

#include <vector>

#include "daemon/pipeline/stream_item.hpp"
#include "drivers/measurement/slot_ring.hpp"
#include "fusion/geometry/trajectory.hpp"

namespace infuse::daemon {

/// Sweeps that wait until odometry covers their time. Used on the fusion thread.
class SweepQueue {
 public:
  /// Holds at most `capacity` sweeps, each for at most `max_wait` of drive time.
  SweepQueue(size_t capacity, Duration max_wait);

  void push(Pin<StreamItem> sweep) { waiting_.push_back(std::move(sweep)); }

  /// Returns true if the oldest sweep waits no longer: the trajectory covers it or never will, or
  /// it has waited `max_wait` at the drive time `now`, or the queue is full.
  bool has_due(const geometry::Trajectory& trajectory, Stamp now) const;

  bool empty() const { return waiting_.empty(); }

  /// Removes and returns the oldest sweep.
  Pin<StreamItem> pop();

 private:
  size_t capacity_;
  Duration max_wait_;
  std::vector<Pin<StreamItem>> waiting_;
};

}  // namespace infuse::daemon

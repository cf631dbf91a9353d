#include "daemon/pipeline/sweep_queue.hpp"

namespace infuse::daemon {

SweepQueue::SweepQueue(size_t capacity, Duration max_wait)
    : capacity_(capacity), max_wait_(max_wait) {
  waiting_.reserve(capacity + 1);
}

bool SweepQueue::has_due(const geometry::Trajectory& trajectory, Stamp now) const {
  if (waiting_.empty()) return false;
  const Sweep& sweep = waiting_.front()->sweep;
  const Stamp end = sweep.stamp + sweep.span;
  const bool too_early = !trajectory.empty() && sweep.stamp < trajectory[0].stamp;
  return waiting_.size() > capacity_ || now - end >= max_wait_ || too_early ||
         *trajectory.uncovered_reason(sweep.stamp, end) == '\0';
}

Pin<StreamItem> SweepQueue::pop() {
  Pin<StreamItem> oldest = std::move(waiting_.front());
  waiting_.erase(waiting_.begin());
  return oldest;
}

}  // namespace infuse::daemon

#pragma once

#include <atomic>
#include <mutex>
#include <vector>

#include "daemon/protocol/request.hpp"

namespace infuse::daemon {

/// Queue of the owner's requests, from the server's thread to the fusion thread.
class ControlQueue {
 public:
  /// Adds a request; from any thread.
  void push(const Request& request) {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(request);
    has_pending_.store(true);
  }

  /// Calls `handle(const Request&)` for every queued request; from the fusion thread.
  template <class Handle>
  void drain(Handle handle) {
    if (!has_pending_.load(std::memory_order_relaxed)) return;
    const std::lock_guard lock(mutex_);
    for (const Request& request : waiting_) handle(request);
    waiting_.clear();
    has_pending_.store(false);
  }

 private:
  std::mutex mutex_;
  std::vector<Request> waiting_;
  std::atomic<bool> has_pending_{false};
};

}  // namespace infuse::daemon

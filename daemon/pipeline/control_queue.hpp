#pragma once

#include <atomic>
#include <mutex>
#include <utility>
#include <vector>

namespace infuse::daemon {

/// Queue of what is asked of the fusion thread, from other threads.
template <class Command>
class ControlQueue {
 public:
  /// Adds a command; from any thread.
  void push(Command command) {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(command));
    has_pending_.store(true);
  }

  /// Calls `handle(const Command&)` for every queued command; from the fusion thread. The lock is
  /// not held meanwhile: `handle` may wait for the server's thread.
  template <class Handle>
  void drain(Handle handle) {
    if (!has_pending_.load(std::memory_order_relaxed)) return;
    std::vector<Command> commands;
    {
      const std::lock_guard lock(mutex_);
      commands.swap(waiting_);
      has_pending_.store(false);
    }
    for (const Command& command : commands) handle(command);
  }

 private:
  std::mutex mutex_;
  std::vector<Command> waiting_;
  std::atomic<bool> has_pending_{false};
};

}  // namespace infuse::daemon

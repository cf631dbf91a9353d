#pragma once

#include <atomic>
#include <mutex>
#include <vector>

#include "daemon/calibration/calibration_command.hpp"

namespace infuse::daemon {

/// Queue of the owner's commands, from the server's thread to the fusion thread.
class ControlQueue {
 public:
  /// Adds a command; from any thread.
  void push(const CalibrationCommand& command) {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(command);
    has_pending_.store(true);
  }

  /// Calls `handle(const CalibrationCommand&)` for every queued command; from the fusion thread.
  /// The lock is not held meanwhile: `handle` may wait for the server's thread.
  template <class Handle>
  void drain(Handle handle) {
    if (!has_pending_.load(std::memory_order_relaxed)) return;
    std::vector<CalibrationCommand> commands;
    {
      const std::lock_guard lock(mutex_);
      commands.swap(waiting_);
      has_pending_.store(false);
    }
    for (const CalibrationCommand& command : commands) handle(command);
  }

 private:
  std::mutex mutex_;
  std::vector<CalibrationCommand> waiting_;
  std::atomic<bool> has_pending_{false};
};

}  // namespace infuse::daemon

#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "daemon/process/idle_time.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Runs work on a thread of its own with the lowest priority. A result becomes visible at the drive
/// time of its start plus a stated budget, not when it is ready: a replay gives the same reports at
/// any rate and on any machine.
class BackgroundWorker {
 public:
  /// `blocking`: `consume_result` waits for a result that is due (replay); false: it becomes
  /// visible later (live).
  explicit BackgroundWorker(bool blocking);
  ~BackgroundWorker();

  /// Work to be done; returns soon after a stop was requested.
  using Work = std::function<void(std::stop_token)>;

  /// Starts `work` at the drive time `now`. Requires `!busy()`.
  void start(Stamp now, Duration budget, Work work);

  /// True while work runs, or its result has not been consumed.
  bool busy() const;

  /// Returns true, once, if the result of the work is visible at the drive time `now`.
  bool consume_result(Stamp now);

  /// Stops the work; its result never becomes visible.
  void cancel();

  /// Stops the work and accepts no more; from any thread.
  void shut_down();

 private:
  void run();

  const bool blocking_;
  std::optional<Stamp> visible_at_;  // used by the caller's thread only
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Work work_;  // empty: nothing to do
  std::stop_source stop_;
  bool done_ = true;
  bool shut_down_ = false;
  IdleTime idle_;
  std::jthread thread_;  // last member: uses the others
};

}  // namespace infuse::daemon

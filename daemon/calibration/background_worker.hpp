#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Work that may wait, on a thread of its own with the lowest priority. A result becomes visible at
/// the drive time of its start plus a stated budget, not when it happens to be ready: so a replay
/// tells the same at any rate and on any machine.
class BackgroundWorker {
 public:
  /// `waits`: whoever asks for a result that is due waits for it (a replay); false: it comes later
  /// (live).
  explicit BackgroundWorker(bool blocking);
  ~BackgroundWorker();

  /// What is to be done; comes to an end soon after it is asked to stop.
  using Work = std::function<void(std::stop_token)>;

  /// Begins `work` at the drive time `now`. Not while `busy()`.
  void start(Stamp now, Duration budget, Work work);

  /// There is work that goes on, or whose result has not been taken.
  bool busy() const;

  /// Whether the result of the work is visible at the drive time `now`; true once.
  bool consume_result(Stamp now);

  /// The work is asked to stop, its result never becomes visible.
  void cancel();

  /// The same for good, from any thread: nothing is done from now on.
  void shut_down();

 private:
  void run();

  const bool blocking_;
  std::optional<Stamp> visible_at_;  // of the caller's thread
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Work work_;              // empty: nothing to do
  std::stop_source stop_;  // of the work
  bool done_ = true;
  bool shut_down_ = false;
  std::jthread thread_;  // the last: it uses the others
};

}  // namespace infuse::daemon

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
class Background {
 public:
  /// `waits`: whoever asks for a result that is due waits for it (a replay); false: it comes later
  /// (live).
  explicit Background(bool waits);
  ~Background();

  /// Begins `work` at the drive time `now`. Not while `busy()`.
  void start(Stamp now, Duration budget, std::function<void()> work);

  /// There is work whose result has not been taken.
  bool busy() const { return visible_.has_value(); }

  /// Whether the result of the work is visible at the drive time `now`; true once.
  bool take(Stamp now);

 private:
  void run(std::stop_token stop);

  const bool waits_;
  std::optional<Stamp> visible_;  // of the caller's thread
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::function<void()> work_;  // empty: nothing to do
  bool done_ = false;
  std::jthread thread_;  // the last: it uses the others
};

}  // namespace infuse::daemon

#pragma once

#include <filesystem>
#include <optional>

#include "daemon/protocol/reports.hpp"
#include "daemon/service/saved_state.hpp"

namespace infuse::daemon {

/// Keeps the state that outlives a restart in the state directory, and tells what it says of the
/// run before.
class RunTracker {
 public:
  /// In the folder that the service manager made ($STATE_DIRECTORY); nothing is kept without one.
  static RunTracker from_environment();
  explicit RunTracker(std::filesystem::path file) : file_(std::move(file)) {}

  /// A run begins. An alert where the one before did not end by itself, which says so where it was
  /// the watchdog that ended it.
  std::optional<AlertReport> begin_run(Stamp now);

  /// Writes the state, at most every 10 s. An alert where that can no longer be done, and where it
  /// can again.
  std::optional<AlertReport> save_if_due(Stamp now);

  /// The run ends by itself.
  void end_run(Stamp now);

  const SavedState& state() const { return state_; }

 private:
  static constexpr Duration kSavePeriod{10'000'000'000};

  Result<void> write(Stamp now);

  std::filesystem::path file_;  // empty: nothing is kept
  SavedState state_;
  Stamp last_saved_;
  bool failing_ = false;
};

}  // namespace infuse::daemon

#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "daemon/history/saved_state.hpp"
#include "daemon/protocol/reports.hpp"

namespace infuse::daemon {

/// Saves the state that outlives a restart in the state directory, and reports how the previous run
/// ended.
class RunTracker {
 public:
  /// Uses the service manager's state directory ($STATE_DIRECTORY); nothing is saved if it is not
  /// set.
  static RunTracker from_environment();
  explicit RunTracker(std::filesystem::path file) : file_(std::move(file)) {}

  /// Records the start of a run. Returns an alert if the previous run did not end by itself; the
  /// text states if the watchdog ended it, and where its crash note is. From now on a crash leaves
  /// a note.
  std::optional<AlertReport> begin_run(Stamp now);

  /// Writes the state, at most every 10 s.
  void save_if_due(Stamp now);

  /// Records that the run ended by itself; on a full disk too.
  void end_run(Stamp now);

  /// Why the state could not be written last; empty if it could.
  const std::string& problem() const { return problem_; }

  /// Folder of the state; empty if nothing is saved.
  std::filesystem::path folder() const { return file_.parent_path(); }

  const SavedState& state() const { return state_; }

 private:
  static constexpr Duration kSavePeriod{10'000'000'000};

  void write(Stamp now);

  std::filesystem::path file_;  // empty: nothing is saved
  SavedState state_;
  Stamp last_saved_;
  std::string problem_;
};

}  // namespace infuse::daemon

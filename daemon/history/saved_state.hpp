#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Name of the file in the state directory, and the version of its format.
inline constexpr const char* kSavedStateFile = "state.json";
inline constexpr int kSavedStateForm = 1;

/// State that outlives a restart.
struct SavedState {
  uint64_t starts = 0;         ///< number of starts with this state file
  uint64_t unclean_exits = 0;  ///< number of runs that did not end by themselves
  bool running = false;        ///< true while a run has not ended by itself
  Stamp saved_at;              ///< when this state was written
  Duration total_run_time{0};  ///< of all runs together
};

/// Formats and parses the state file: JSON, filled up with spaces to a fixed length. Errors: not a
/// state file, or of another format version.
std::string format_state(const SavedState& state);
Result<SavedState> parse_state(std::string_view text);

/// Reads a state file. Returns nothing if there is none; an error if it cannot be used.
Result<std::optional<SavedState>> read_state(const std::filesystem::path& path);

}  // namespace infuse::daemon

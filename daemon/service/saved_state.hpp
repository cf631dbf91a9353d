#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// What the daemon knows after a restart.
struct SavedState {
  uint64_t starts = 0;         ///< how often it was started with this state
  uint64_t unclean_exits = 0;  ///< and how often of these it had not ended by itself before
  bool running = false;        ///< it has not ended by itself since
  Stamp saved_at;              ///< when this was written
  Duration total_run_time{0};  ///< all its runs together
};

/// The text of a state, and back. What is no state, or of another form, is an error.
std::string format_state(const SavedState& state);
Result<SavedState> parse_state(std::string_view text);

/// Reads a state's file. Nothing where there is none; an error where it cannot be used.
Result<std::optional<SavedState>> read_state(const std::filesystem::path& path);

}  // namespace infuse::daemon

#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace infuse::daemon {

/// Keeps the recordings of a folder together below a number of bytes, by removing alert recordings,
/// the oldest first. What was recorded on request is never removed. Age is by the time in the
/// names; what has a later name than the recording that was just made is from before the clock was
/// set back, as a computer without a battery does at each start, and so the oldest of all.
class RecordingsBudget {
 public:
  RecordingsBudget(std::filesystem::path directory, uint64_t budget)
      : directory_(std::move(directory)), budget_(budget) {}

  /// Measures what is in the folder, without the drives of the recording `current` ("NAME",
  /// "NAME.2", …), which begins now.
  void measure(const std::string& current);

  /// Removes alert recordings until there is room for `bytes` of the current recording. False if
  /// there is not enough to remove.
  bool make_room(uint64_t bytes);

 private:
  struct Drive {
    std::filesystem::path folder;
    uint64_t bytes = 0;
  };

  std::filesystem::path directory_;
  uint64_t budget_;
  uint64_t bytes_ = 0;         // of all drives but the current recording's
  std::vector<Drive> alerts_;  // newest first
};

/// Removes the oldest alert recordings in a folder beyond the newest `keep`; the drives of one
/// split recording count as one. `last`: name of the recording that was made last.
void remove_old_alerts(const std::filesystem::path& directory, size_t keep,
                       const std::string& last);

/// Prefix of the names of alert recordings.
inline constexpr const char* kAlertPrefix = "alert-";

}  // namespace infuse::daemon

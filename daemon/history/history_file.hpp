#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Name of the file in the state directory.
inline constexpr const char* kHistoryFile = "history.jsonl";
/// Version of its lines, their member "form". Lines of another version are counted, not read.
inline constexpr int kHistoryForm = 1;

/// A text file of bounded size to which lines are appended. Lines rather than a database: a crash
/// or a full disk costs the last line at most, any tool reads it, and nothing is ever rewritten.
/// When it is full it is renamed to PATH.1, which replaces an older one, and begun anew.
class HistoryFile {
 public:
  /// Maximum size of each of the two files, bytes: a quiet year takes 3 MB.
  static constexpr uint64_t kMaxBytes = uint64_t{16} << 20;

  explicit HistoryFile(std::filesystem::path path, uint64_t max_bytes = kMaxBytes)
      : path_(std::move(path)), max_bytes_(max_bytes) {}

  /// Appends a line, given without its end: it is in the file whole, or not at all.
  Result<void> append(std::string_view line) const;

 private:
  std::filesystem::path path_;
  uint64_t max_bytes_;
};

/// Reads the lines of PATH.1 and PATH, oldest first; none if there is no file. Fails if the folder
/// or a file cannot be read.
Result<std::vector<std::string>> read_history(const std::filesystem::path& path);

}  // namespace infuse::daemon

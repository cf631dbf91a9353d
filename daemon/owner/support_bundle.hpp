#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// What support asks for: texts in an archive, without secrets.
class SupportBundle {
 public:
  /// Adds a text; what `hide_secrets_of` has found is replaced.
  void add(const std::string& name, std::string text);

  /// Finds the secrets of a configuration: the values of token, and passwords in addresses. To be
  /// called before texts are added that may repeat them.
  void hide_secrets_of(std::string_view config);

  /// Number of texts.
  size_t size() const { return entries_.size(); }

  /// The archive: tar (POSIX ustar), every file in `folder`.
  std::string tar(const std::string& folder) const;

  /// Writes the archive compressed by zstd, readable by its owner only.
  Result<void> write(const std::filesystem::path& file) const;

 private:
  struct Entry {
    std::string name, text;
  };
  std::vector<Entry> entries_;
  std::vector<std::string> secrets_;
};

}  // namespace infuse::daemon

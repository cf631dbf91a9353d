#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>

#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// The file that `--reports` writes: a line a report. The first failure is kept and told at the
/// end.
class ReportsFile {
 public:
  static Result<ReportsFile> create(const std::filesystem::path& path);

  /// Appends one line; `message` is without its line feed.
  void write(std::string_view message);

  /// Flushes. Fails where anything could not be written.
  Result<void> close();

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  ReportsFile(std::FILE* file, std::filesystem::path path) : file_(file), path_(std::move(path)) {}

  std::unique_ptr<std::FILE, Closer> file_;
  std::filesystem::path path_;
  std::optional<Error> error_;
};

}  // namespace infuse::daemon

#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>

#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// The file written by `--reports`: one line per report. The first failure is returned by `close`.
class ReportsFile {
 public:
  /// Creates or truncates the file.
  static Result<ReportsFile> create(const std::filesystem::path& path);

  /// Appends one line; `message` is without its line feed.
  void write(std::string_view message);

  /// Flushes. Fails if anything could not be written.
  Result<void> close();

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void set_error();
  ReportsFile(std::FILE* file, std::filesystem::path path) : file_(file), path_(std::move(path)) {}

  std::unique_ptr<std::FILE, Closer> file_;
  std::filesystem::path path_;
  std::optional<Error> error_;
};

}  // namespace infuse::daemon

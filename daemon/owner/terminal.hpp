#pragma once

#include <string>
#include <utility>

#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// The whole terminal at standard output, restored at the end, also by SIGINT and SIGTERM. One at a
/// time.
class Terminal {
 public:
  /// Fails if standard output is not a terminal.
  static Result<void> check();

  Terminal();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// Columns and rows at present.
  static std::pair<size_t, size_t> size();

  /// Draws lines over what is there.
  static void draw(const std::string& lines);
};

}  // namespace infuse::daemon

#pragma once

#include <optional>
#include <string>

namespace infuse::daemon {

/// One line on standard error that is overwritten at every update; nothing if standard error is not
/// a terminal.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine() { clear(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// True if standard error is a terminal.
  bool visible() const { return visible_; }

  /// Shows a bar for `fraction` (0 … 1; no bar if unknown), followed by the text.
  void show(std::optional<double> fraction, const std::string& text);

  /// Removes the line.
  void clear();

 private:
  bool visible_;
  bool shown_ = false;
};

}  // namespace infuse::daemon

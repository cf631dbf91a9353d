#pragma once

#include <optional>
#include <string>

namespace infuse::daemon {

/// One line on standard error that is overwritten again and again; nothing where that is not a
/// terminal.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine() { clear(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Whether anyone sees it.
  bool visible() const { return visible_; }

  /// A bar for `fraction` (0 … 1; none where it is not known), then the text.
  void show(std::optional<double> fraction, const std::string& text);

  /// Takes the line away.
  void clear();

 private:
  bool visible_;
  bool shown_ = false;
};

}  // namespace infuse::daemon

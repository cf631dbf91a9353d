#include "daemon/command_line/progress_line.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace infuse::daemon {
namespace {

std::string bar(double fraction) {
  constexpr int kCells = 24;
  const int full = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * kCells);
  std::string cells;
  for (int i = 0; i < kCells; ++i) cells += i < full ? "█" : "░";
  return cells + " " + std::to_string(static_cast<int>(100 * fraction)) + " %  ";
}

}  // namespace

ProgressLine::ProgressLine() : visible_(isatty(STDERR_FILENO) == 1) {}

void ProgressLine::show(std::optional<double> fraction, const std::string& text) {
  if (!visible_) return;
  std::fprintf(stderr, "\r\033[K%s%s", fraction ? bar(*fraction).c_str() : "", text.c_str());
  std::fflush(stderr);
  shown_ = true;
}

void ProgressLine::clear() {
  if (!shown_) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
  shown_ = false;
}

}  // namespace infuse::daemon

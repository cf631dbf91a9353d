#include "daemon/owner/terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <csignal>
#include <string_view>

namespace infuse::daemon {
namespace {

// The other screen of the terminal, without a cursor (ECMA-48, xterm's control sequences).
constexpr std::string_view kEnter = "\x1b[?1049h\x1b[?25l", kLeave = "\x1b[?25h\x1b[?1049l";

void write_all(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDOUT_FILENO, text.data(), text.size());
    if (written <= 0) return;
    text.remove_prefix(static_cast<size_t>(written));
  }
}

extern "C" void leave_and_raise(int signal) {
  write_all(kLeave);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

Result<void> Terminal::check() {
  if (::isatty(STDOUT_FILENO) != 0) return {};
  return fail("the output is no terminal", "--tui", "leave it out to print lines");
}

Terminal::Terminal() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, leave_and_raise);
  write_all(kEnter);
}

Terminal::~Terminal() {
  write_all(kLeave);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_DFL);
}

std::pair<size_t, size_t> Terminal::size() {
  winsize window{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) != 0 || window.ws_col == 0) return {80, 24};
  return {window.ws_col, window.ws_row};
}

void Terminal::draw(const std::string& lines) {
  std::string out = "\x1b[H";
  for (const char c : lines) {
    if (c == '\n') {
      out += "\x1b[K\r\n";
    } else {
      out.push_back(c);
    }
  }
  write_all(out + "\x1b[K\x1b[J");
}

}  // namespace infuse::daemon

#include "daemon/process/abort_marker.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <csignal>

#include "daemon/process/crash_note.hpp"

namespace infuse::daemon {
namespace {

std::array<char, 4096> marker_path{};  // a signal handler may not allocate

// Async-signal-safe calls only. SA_RESETHAND restored the default action: the second signal ends
// the process.
void on_abort(int signal, siginfo_t* about, void* /*context*/) {
  constexpr mode_t kMode = 0640;
  if (about->si_code == SI_USER) {  // abort() of this process itself has another code
    const int file = open(marker_path.data(), O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW, kMode);
    if (file >= 0) close(file);
  }
  write_crash_note(signal);
  raise(signal);
}

}  // namespace

void install_abort_handler(const std::filesystem::path& file) {
  const std::string& path = file.native();
  if (path.size() >= marker_path.size()) return;
  marker_path.fill('\0');
  path.copy(marker_path.data(), path.size());
  struct sigaction action {};
  action.sa_sigaction = on_abort;
  action.sa_flags = SA_SIGINFO | static_cast<int>(SA_RESETHAND) | SA_NODEFER;
  sigaction(SIGABRT, &action, nullptr);
}

bool consume_abort_marker(const std::filesystem::path& file) { return unlink(file.c_str()) == 0; }

}  // namespace infuse::daemon

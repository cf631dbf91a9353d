#include "daemon/owner/config_trial.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <span>

#include "drivers/recording/atomic_file.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxTrialBytes = 1 << 20;

Result<void> write(const fs::path& file, std::string_view text) {
  return recording::write_file_atomically(file, std::as_bytes(std::span(text)));
}

/// "PID START", which no later process has; empty if there is no such process. START is field 22 of
/// proc(5)'s stat, behind the program's name in parentheses.
std::string identity_of(const std::string& pid) {
  const auto stat = text::read_text("/proc/" + pid + "/stat", 4096);
  const size_t name_end = stat ? stat->rfind(')') : std::string::npos;
  if (name_end == std::string::npos) return {};
  size_t at = name_end;
  constexpr int kFieldsBehindName = 20;
  for (int field = 0; field < kFieldsBehindName && at != std::string::npos; ++field) {
    at = stat->find(' ', at + 1);
  }
  if (at == std::string::npos) return {};
  return pid + " " + stat->substr(at + 1, stat->find(' ', at + 1) - at - 1);
}

}  // namespace

ConfigTrial::ConfigTrial(fs::path file)
    : file_(std::move(file)),
      previous_(file_.string() + ".previous"),
      trying_(file_.string() + ".trying") {}

Result<void> ConfigTrial::begin(std::string_view text) const {
  if (auto settled = settle(); !settled) return tl::unexpected(settled.error());
  std::error_code failed;
  if (fs::exists(trying_, failed)) {
    return fail("another configuration is being tried", trying_.string(), "wait for its end");
  }
  const auto present = text::read_text(file_, kMaxTrialBytes);
  if (!present) return tl::unexpected(present.error());
  // The copy has the mode of the original: it may hold a token.
  if (!fs::exists(previous_, failed)) {
    if (!fs::copy_file(file_, previous_, failed)) {
      return fail("cannot be written: " + failed.message(), previous_.string());
    }
  }
  if (auto kept = write(previous_, *present); !kept) return kept;
  if (auto marked = write(trying_, identity_of(std::to_string(::getpid()))); !marked) return marked;
  return write(file_, text);
}

Result<void> ConfigTrial::confirm() const {
  if (::unlink(trying_.c_str()) == 0 || errno == ENOENT) return {};
  return fail(std::string("cannot be removed: ") + std::strerror(errno), trying_.string());
}

Result<void> ConfigTrial::restore() const {
  const auto previous = text::read_text(previous_, kMaxTrialBytes);
  if (!previous) return tl::unexpected(previous.error());
  return write(file_, *previous).and_then([this] { return confirm(); });
}

Result<bool> ConfigTrial::settle() const {
  std::error_code failed;
  if (!fs::exists(trying_, failed)) return false;
  const auto marker = text::read_text(trying_, kMaxTrialBytes);
  if (!marker) return tl::unexpected(marker.error());
  if (!marker->empty() && identity_of(marker->substr(0, marker->find(' '))) == *marker)
    return false;
  return restore().map([] { return true; });
}

}  // namespace infuse::daemon

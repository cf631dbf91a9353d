#include "daemon/history/run_tracker.hpp"

#include <fcntl.h>
#include <spdlog/fmt/chrono.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdlib>

#include "daemon/health/service_alerts.hpp"
#include "daemon/process/abort_marker.hpp"
#include "daemon/process/crash_note.hpp"
#include "drivers/host/file_descriptor.hpp"
#include "drivers/recording/atomic_file.hpp"

namespace infuse::daemon {
namespace {

// Beside the state.
constexpr const char* kAbortMarkerFile = "abort_marker";
constexpr const char* kCrashNoteFile = "crash_note";

/// "it was last seen 7 s ago". The clock may have been set back since, or was not set yet.
std::string last_seen_text(Stamp last_seen, Stamp now) {
  if (now < last_seen) return "it is not known when it was last seen: the clock was set back";
  return fmt::format("it was last seen {:.0f} s ago", to_seconds(now - last_seen));
}

/// "20261121-061136".
std::string utc_name(Stamp stamp) {
  const auto seconds = static_cast<std::time_t>(stamp.ns() / 1'000'000'000);
  return fmt::format("{:%Y%m%d-%H%M%S}", fmt::gmtime(seconds));
}

}  // namespace

RunTracker RunTracker::from_environment() {
  const char* folder = std::getenv("STATE_DIRECTORY");
  if (folder == nullptr || *folder != '/') return RunTracker({});
  return RunTracker(std::filesystem::path(folder) / kSavedStateFile);
}

std::optional<AlertReport> RunTracker::begin_run(Stamp now) {
  if (file_.empty()) return std::nullopt;
  if (const auto before = read_state(file_); !before) {
    // Damaged, or of another release, to which a user may go back.
    spdlog::warn("{}", before.error().message());
    std::error_code ignored;
    std::filesystem::rename(file_, file_.string() + ".unreadable", ignored);
  } else if (*before) {
    state_ = **before;
  }
  const bool unclean = state_.running;
  const Stamp last_seen = state_.saved_at;
  ++state_.starts;
  if (unclean) ++state_.unclean_exits;
  state_.running = true;
  write(now);
  const std::filesystem::path marker = file_.parent_path() / kAbortMarkerFile;
  const bool aborted = consume_abort_marker(marker);
  install_abort_handler(marker);
  const std::filesystem::path note = file_.parent_path() / kCrashNoteFile;
  const auto crash = keep_crash_note(note, utc_name(now));
  install_crash_handler(note);
  if (!unclean) return std::nullopt;
  std::string what = aborted ? "the watchdog ended the previous run, which was stuck"
                     : crash ? "the previous run crashed"
                     : problem_.empty()
                         ? "the previous run did not end by itself"
                         : "the previous run did not end by itself, or its end could not be saved";
  if (crash) what += " (" + *crash + ")";
  const Problem problem{fmt::format("{}; {}; unclean exits so far: {}", what,
                                    last_seen_text(last_seen, now), state_.unclean_exits),
                        "see journalctl -u infused"};
  return AlertReport{now, kDaemonDevice, true, make_finding(kRestartedAlert, now, problem)};
}

void RunTracker::save_if_due(Stamp now) {
  if (!file_.empty() && now - last_saved_ >= kSavePeriod) write(now);
}

// On a full disk there is no room for a second file: the text has a fixed length, and replaces the
// one that is there.
void RunTracker::end_run(Stamp now) {
  if (file_.empty()) return;
  state_.running = false;
  write(now);
  if (problem_.empty()) return;
  const std::string text = format_state(state_);
  const host::FileDescriptor file(::open(file_.c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW));
  if (!file || ::pwrite(file.get(), text.data(), text.size(), 0) < 0 || ::fsync(file.get()) != 0) {
    spdlog::error("cannot save that this run ended by itself: {}", problem_);
  }
}

void RunTracker::write(Stamp now) {
  if (last_saved_ != Stamp() && now > last_saved_) state_.total_run_time += now - last_saved_;
  last_saved_ = now;
  state_.saved_at = now;
  const std::string text = format_state(state_);
  const auto written =
      recording::write_file_atomically(file_, std::as_bytes(std::span(text)), 0640);
  problem_ = written ? "" : written.error().message();
}

}  // namespace infuse::daemon

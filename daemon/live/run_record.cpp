#include "daemon/live/run_record.hpp"

#include <spdlog/spdlog.h>

#include <cstdlib>

#include "daemon/service/abort_note.hpp"
#include "daemon/service/atomic_file.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kDevice = "infused";
constexpr const char* kAbortNote = "aborted";  // beside the state

}  // namespace

RunRecord RunRecord::from_environment() {
  const char* folder = std::getenv("STATE_DIRECTORY");
  if (folder == nullptr || *folder != '/') return RunRecord({});
  return RunRecord(std::filesystem::path(folder) / "state.json");
}

std::optional<AlertReport> RunRecord::begin(Stamp now) {
  if (file_.empty()) return std::nullopt;
  if (const auto before = read_state(file_); !before) {
    spdlog::warn("{}", before.error().message());
  } else if (*before) {
    state_ = **before;
  }
  const bool unclean = state_.running;
  const Stamp last_seen = state_.saved;
  ++state_.starts;
  if (unclean) ++state_.unclean;
  state_.running = true;
  if (const auto written = write(now); !written) spdlog::error("{}", written.error().message());
  const std::filesystem::path note = file_.parent_path() / kAbortNote;
  const bool aborted = take_abort_note(note);
  leave_note_on_abort(note);
  if (!unclean) return std::nullopt;
  const char* what = aborted ? "the watchdog ended the run before, which was stuck"
                             : "the run before did not end by itself";
  spdlog::warn("{}", what);
  return AlertReport{now,
                     kDevice,
                     true,
                     {"restarted", Level::kWarn, now,
                      fmt::format("{}; it was last seen {:.0f} s ago, and this is the {}. time",
                                  what, to_seconds(now - last_seen), state_.unclean),
                      "look at: journalctl -u infused"}};
}

std::optional<AlertReport> RunRecord::keep(Stamp now) {
  if (file_.empty() || now - written_ < kPeriod) return std::nullopt;
  const auto written = write(now);
  if (written.has_value() != failing_) return std::nullopt;
  failing_ = !written.has_value();
  const std::string what = failing_ ? written.error().message() : "the state can be written again";
  spdlog::warn("{}", what);
  return AlertReport{
      now,
      kDevice,
      failing_,
      {"state", Level::kWarn, now, what, "make room on the disk of the state directory"}};
}

void RunRecord::end(Stamp now) {
  if (file_.empty()) return;
  state_.running = false;
  if (const auto written = write(now); !written) spdlog::error("{}", written.error().message());
}

Result<void> RunRecord::write(Stamp now) {
  if (written_ != Stamp() && now > written_) state_.running_for += now - written_;
  written_ = now;
  state_.saved = now;
  return write_atomically(file_, format_state(state_));
}

}  // namespace infuse::daemon

#include "daemon/command_line/replay_progress.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {
namespace {

constexpr std::chrono::milliseconds kProgressPeriod{100};

}  // namespace

double ReplayProgress::since_begin_s() const {
  return std::chrono::duration<double>(HostClock::now() - begin_).count();
}

void ReplayProgress::start(const Replay& replay, bool visible) {
  begin_ = HostClock::now();
  if (visible && line_.visible()) show(replay);
}

void ReplayProgress::show(const Replay& replay) {
  const Totals& totals = replay.totals();
  const double drive_s = to_seconds(totals.now - totals.start);
  line_.show(replay.progress(), fmt::format("{:.0f} s of drive, {:.1f} × real time", drive_s,
                                            drive_s / since_begin_s()));
  timer_.expires_after(kProgressPeriod);
  timer_.async_wait([this, &replay](boost::system::error_code error) {
    if (!error) show(replay);
  });
}

void ReplayProgress::stop() {
  host_s_ = since_begin_s();
  timer_.cancel();
  line_.clear();
}

}  // namespace infuse::daemon

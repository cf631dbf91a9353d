#include "daemon/pipeline/pacer.hpp"

namespace infuse::daemon {

void Pacer::set_rate(double rate) {
  const std::lock_guard lock(mutex_);
  rate_ = rate;
  drive_start_.reset();
  changed_.notify_all();
}

void Pacer::wait_until(Stamp stamp, std::stop_token stop) {
  std::unique_lock lock(mutex_);
  const Stamp previous = std::exchange(previous_, stamp);
  if (drive_start_ && (stamp - previous > kMaxPause || previous - stamp > kMaxPause)) {
    drive_start_.reset();
  }
  while (rate_ && !stop.stop_requested()) {
    if (*rate_ == 0) {
      changed_.wait(lock, stop, [&] { return *rate_ != 0; });
      continue;
    }
    if (!drive_start_) {
      drive_start_ = stamp;
      host_start_ = HostClock::now();
    }
    const Duration due = from_seconds(to_seconds(stamp - *drive_start_) / *rate_);
    const HostClock::time_point until = host_start_ + due;
    if (HostClock::now() >= until) return;
    changed_.wait_until(lock, stop, until, [&] { return !drive_start_; });
  }
}

}  // namespace infuse::daemon

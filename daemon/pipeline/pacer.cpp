#include "daemon/pipeline/pacer.hpp"

namespace infuse::daemon {

void Pacer::wait_until(Stamp stamp, std::stop_token stop) {
  if (!rate_) return;
  if (!drive_start_ || stamp - previous_ > kMaxPause || previous_ - stamp > kMaxPause) {
    drive_start_ = stamp;
    host_start_ = HostClock::now();
  }
  previous_ = stamp;
  const Duration due = from_seconds(to_seconds(stamp - *drive_start_) / *rate_);
  const HostClock::time_point until = host_start_ + due;
  if (HostClock::now() >= until) return;
  std::unique_lock lock(mutex_);
  stopped_.wait_until(lock, stop, until, [] { return false; });
}

}  // namespace infuse::daemon

#include "daemon/pipeline/pacer.hpp"

#include <utility>

namespace infuse::daemon {

void Pacer::begin() {
  const std::lock_guard lock(mutex_);
  held_ = false;
  changed_.notify_all();
}

void Pacer::set_rate(double rate) {
  const std::lock_guard lock(mutex_);
  rate_ = rate;
  end_seek();
}

void Pacer::step() {
  const std::lock_guard lock(mutex_);
  rate_ = 0;
  end_seek();
  stepping_ = true;
}

void Pacer::seek(Stamp stamp) {
  const std::lock_guard lock(mutex_);
  end_seek();
  seek_ = stamp;
}

void Pacer::seek_alert() {
  const std::lock_guard lock(mutex_);
  end_seek();
  seeking_alert_ = true;
}

void Pacer::reach_alert() {
  const std::lock_guard lock(mutex_);
  if (!seeking_alert_) return;
  rate_ = 0;
  end_seek();
}

void Pacer::reach_sweep() {
  const std::lock_guard lock(mutex_);
  if (stepping_) end_seek();
}

bool Pacer::is_free(Stamp stamp) const { return seeking_alert_ || (seek_ && stamp < *seek_); }

// What was due is computed anew from the next event on.
void Pacer::end_seek() {
  seek_.reset();
  seeking_alert_ = false;
  stepping_ = false;
  drive_start_.reset();
  changed_.notify_all();
}

void Pacer::wait_until(Stamp stamp, std::stop_token stop) {
  std::unique_lock lock(mutex_);
  if (held_) changed_.wait(lock, stop, [&] { return !held_; });
  const Stamp previous = std::exchange(previous_, stamp);
  if (drive_start_ && (stamp - previous > kMaxPause || previous - stamp > kMaxPause)) {
    drive_start_.reset();
  }
  while (rate_ && !stop.stop_requested()) {
    if (is_free(stamp)) return;
    if (seek_) end_seek();
    const double rate = stepping_ ? kStepRate : *rate_;
    if (rate == 0) {
      changed_.wait(lock, stop, [&] { return *rate_ != 0 || stepping_ || is_free(stamp); });
      continue;
    }
    if (!drive_start_) {
      drive_start_ = stamp;
      host_start_ = HostClock::now();
    }
    const Duration due = from_seconds(to_seconds(stamp - *drive_start_) / rate);
    const HostClock::time_point until = host_start_ + due;
    if (HostClock::now() >= until) return;
    changed_.wait_until(lock, stop, until, [&] { return !drive_start_ || is_free(stamp); });
  }
}

}  // namespace infuse::daemon

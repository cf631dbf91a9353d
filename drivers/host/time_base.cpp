#include "drivers/host/time_base.hpp"

#include <cstdlib>
#include <ctime>

namespace infuse::host {
namespace {

int64_t read_clock(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
}

}  // namespace

ClockReading ClockReading::now() {
  const int64_t before = read_clock(CLOCK_MONOTONIC);
  const int64_t wall = read_clock(CLOCK_REALTIME);
  const int64_t after = read_clock(CLOCK_MONOTONIC);
  return {before + (after - before) / 2, wall};
}

void WallStamps::update(const ClockReading& now) {
  const int64_t gap = now.monotonic_ns - reading_.monotonic_ns;
  const int64_t gained = now.wall_ns - reading_.wall_ns - gap;
  stepped_ = has_reading_ && std::abs(gained) > kMinStepNs + gap / kDriftDivisor;
  if (stepped_) ++steps_;
  has_reading_ = true;
  reading_ = now;
  last_update_ = base_.at_monotonic(now.monotonic_ns);
}

Stamp WallStamps::stamp_of(int64_t wall_ns) const {
  const int64_t age = reading_.wall_ns - wall_ns;
  if (stepped_ || age < 0 || age > kMaxAgeNs) return last_update_;
  return last_update_ - Duration(age);
}

}  // namespace infuse::host

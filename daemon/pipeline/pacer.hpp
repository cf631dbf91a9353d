#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>

#include "daemon/pipeline/stream_item.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Paces a replay at a multiple of real time.
class Pacer {
 public:
  /// `rate`: 1 is real time; nothing: as fast as possible.
  explicit Pacer(std::optional<double> rate) : rate_(rate) {}

  /// Returns when the event of this stamp is due, or a stop is requested. A pause of more than 10 s
  /// of drive time, or a step back, is skipped.
  void wait_until(Stamp stamp, std::stop_token stop);

  /// Changes the rate, from any thread; 0 pauses.
  void set_rate(double rate);

 private:
  static constexpr Duration kMaxPause{10'000'000'000};

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<double> rate_;
  std::optional<Stamp> drive_start_;  // of the present rate
  Stamp previous_;
  HostClock::time_point host_start_;
};

}  // namespace infuse::daemon

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

 private:
  static constexpr Duration kMaxPause{10'000'000'000};

  std::optional<double> rate_;
  std::optional<Stamp> drive_start_;
  Stamp previous_;
  HostClock::time_point host_start_;
  std::mutex mutex_;
  std::condition_variable_any stopped_;
};

}  // namespace infuse::daemon

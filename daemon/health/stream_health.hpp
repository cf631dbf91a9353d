#pragma once

#include <string>
#include <vector>

#include "daemon/health/conditions.hpp"
#include "daemon/health/health_options.hpp"
#include "daemon/health/snapshot_window.hpp"
#include "daemon/health/stream_counters.hpp"

namespace infuse::daemon {

/// How a camera or one of the vehicle's own sensors is at one moment.
struct StreamStatus {
  Level level = Level::kOk;
  double received_hz = 0;  ///< over the window, at most the last 10 s
  StreamCounters counters;
  std::vector<Finding> findings;        ///< what is wrong now, the worst first
  std::vector<Transition> transitions;  ///< what changed at this tick
};

/// Judges one such stream by its counters. A pure state machine over snapshots and drive time.
class StreamHealth {
 public:
  /// `endpoint` says where it comes from, for sentences; `start` is when listening began.
  StreamHealth(std::string endpoint, const HealthOptions& options, Stamp start);

  /// As SensorHealth's.
  const StreamStatus& update(Stamp now, const StreamCounters& counters);

  /// Judges by these thresholds from now on; how long conditions hold before they are told stays.
  void set_options(const HealthOptions& options) { options_ = options; }

 private:
  using Window = SnapshotWindow<StreamCounters>;

  CheckResult check_silence(Stamp now, const StreamCounters& counters);
  CheckResult check_readability(const StreamCounters& now, const StreamCounters& before) const;
  CheckResult check_use(const StreamCounters& now, const StreamCounters& before) const;
  CheckResult check_loss(const StreamCounters& now, const StreamCounters& before) const;
  CheckResult check_order(const StreamCounters& now, const StreamCounters& before) const;

  std::string endpoint_;
  HealthOptions options_;
  Stamp last_received_;  // or the start, while there is none
  Stamp previous_tick_;  // tick
  uint64_t received_ = 0;
  Window window_;
  Conditions conditions_;
  StreamStatus status_;
};

}  // namespace infuse::daemon

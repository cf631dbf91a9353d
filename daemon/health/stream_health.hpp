#pragma once

#include <limits>
#include <string>
#include <vector>

#include "daemon/health/alert_checks.hpp"
#include "daemon/health/health_options.hpp"
#include "daemon/health/snapshot_window.hpp"
#include "daemon/health/stream_alerts.hpp"
#include "daemon/health/stream_counters.hpp"

namespace infuse::daemon {

/// Health of a camera or a vehicle sensor at one tick.
struct StreamStatus {
  Level level = Level::kOk;
  double received_hz = 0;  ///< over the window, at most the last 10 s
  StreamCounters counters;
  std::vector<Finding> findings;        ///< raised at present, the worst first
  std::vector<Transition> transitions;  ///< changes at this tick
};

/// Checks one such stream by its counters. A pure state machine over snapshots and drive time.
class StreamHealth {
 public:
  /// `endpoint`: where its data comes from, for messages. `start`: when reception began. `max_hz`:
  /// the most that such a sensor sends.
  StreamHealth(std::string endpoint, const HealthOptions& options, Stamp start,
               double max_hz = std::numeric_limits<double>::infinity());

  /// As LidarHealth::update.
  const StreamStatus& update(Stamp now, const StreamCounters& counters);

  /// Replaces the thresholds; the delays of raising and clearing stay.
  void set_options(const HealthOptions& options) { options_ = options; }

 private:
  using Window = SnapshotWindow<StreamCounters>;

  std::string endpoint_;
  HealthOptions options_;
  double max_hz_;
  Stamp last_received_;  // the start, while there is none
  Stamp previous_tick_;
  uint64_t received_ = 0;
  Window window_;
  AlertChecks<StreamTick> checks_;
  StreamStatus status_;
};

}  // namespace infuse::daemon

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/health/alert_checks.hpp"
#include "daemon/health/health_options.hpp"
#include "daemon/health/lidar_alerts.hpp"
#include "daemon/health/lidar_counters.hpp"
#include "daemon/health/snapshot_window.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Health of a lidar at one tick.
struct LidarStatus {
  Level level = Level::kOk;
  double packets_hz = 0;  ///< over the window, at most the last 10 s
  double sweeps_hz = 0;
  double returns_hz = 0;
  double loss = 0;  ///< fraction of the window's packets that were lost
  LidarCounters counters;
  std::vector<Finding> findings;        ///< raised at present, the worst first
  std::vector<Transition> transitions;  ///< changes at this tick
};

/// Checks one lidar by its counters. A pure state machine over snapshots and drive time.
class LidarHealth {
 public:
  /// `endpoint`: where its data is received, for messages: "0.0.0.0:2368". `start`: when reception
  /// began.
  LidarHealth(std::string endpoint, const HealthOptions& options, Stamp start);

  /// Returns the health at `now`, given the counters at `now`; called about once a second. A step
  /// back in time restarts all measurements. The result is valid until the next call.
  const LidarStatus& update(Stamp now, const LidarCounters& counters);

  /// Replaces the thresholds; the delays of raising and clearing stay.
  void set_options(const HealthOptions& options) { options_ = options; }

 private:
  using Window = SnapshotWindow<LidarCounters>;

  void restart_at(Stamp now);
  void note_progress(Stamp now, const LidarCounters& counters);
  void measure_rates(Stamp now, const Window::Snapshot& oldest);

  std::string endpoint_;
  HealthOptions options_;
  Stamp last_packet_;  // the start, while there is none
  Stamp last_sweep_;
  Stamp previous_tick_;
  std::optional<Stamp> first_seen_;  // tick of the first packet
  uint64_t packets_seen_ = 0;
  uint64_t sweeps_seen_ = 0;
  Window window_;
  AlertChecks<LidarTick> checks_;
  LidarStatus status_;
};

}  // namespace infuse::daemon

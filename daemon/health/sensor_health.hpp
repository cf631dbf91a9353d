#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/health/conditions.hpp"
#include "daemon/health/health_options.hpp"
#include "daemon/health/sensor_counters.hpp"
#include "daemon/health/snapshot_window.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// How a sensor is at one moment.
struct SensorStatus {
  Level level = Level::kOk;
  double packets_hz = 0;  ///< over the window, at most the last 10 s
  double sweeps_hz = 0;
  double returns_hz = 0;
  double loss = 0;  ///< fraction of the window's packets that was lost
  SensorCounters counters;
  std::vector<Finding> findings;        ///< what is wrong now, the worst first
  std::vector<Transition> transitions;  ///< what changed at this tick
};

/// Judges one lidar by its counters. A pure state machine over snapshots and drive time.
class SensorHealth {
 public:
  /// `endpoint` says where the sensor is listened to, for sentences: "0.0.0.0:2368". `start` is
  /// when listening began.
  SensorHealth(std::string endpoint, const HealthOptions& options, Stamp start);

  /// Takes the counters as they are at `now` and says how the sensor is. About one call a
  /// second; time that steps back begins anew. The answer is valid until the next call.
  const SensorStatus& update(Stamp now, const SensorCounters& counters);

  /// Judges by these thresholds from now on; how long conditions hold before they are told stays.
  void set_options(const HealthOptions& options) { options_ = options; }

 private:
  using Window = SnapshotWindow<SensorCounters>;

  void restart_at(Stamp now);
  CheckResult check_silence(Stamp now, const SensorCounters& counters);
  CheckResult check_decoding(const SensorCounters& now, const SensorCounters& before) const;
  CheckResult check_sweeps(Stamp now, const SensorCounters& now_counters);
  CheckResult check_loss(const SensorCounters& now, const SensorCounters& before, double min_loss,
                         double max_loss) const;
  CheckResult check_sender(const SensorCounters& now, const SensorCounters& before) const;
  CheckResult check_model(const SensorCounters& now, const SensorCounters& before) const;
  CheckResult check_clock(Stamp now, const SensorCounters& counters);
  void measure_rates(Stamp now, const Window::Snapshot& oldest);

  std::string endpoint_;
  HealthOptions options_;
  Stamp last_packet_;  // or the start, while there is none
  Stamp last_sweep_;
  Stamp previous_tick_;              // tick
  std::optional<Stamp> first_seen_;  // tick of the first packet
  uint64_t packets_seen_ = 0;
  uint64_t sweeps_seen_ = 0;
  Window window_;
  Conditions conditions_;
  SensorStatus status_;
};

}  // namespace infuse::daemon

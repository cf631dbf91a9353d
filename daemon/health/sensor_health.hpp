#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/health/hysteresis.hpp"
#include "daemon/health/sensor_counters.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// How a sensor is, in growing badness.
enum class Level : uint8_t { kOk, kWarn, kError, kStale };

/// "OK", "WARN", "ERROR", "STALE".
const char* name_of(Level level);

/// When a sensor is called unwell. The `[health]` table of the configuration.
struct HealthOptions {
  Duration stale_after{3'000'000'000};   ///< silence after which a sensor is STALE, ns
  Duration raise_after{2'000'000'000};   ///< how long another condition holds before it is told, ns
  Duration clear_after{3'000'000'000};   ///< how long it is absent before it is taken back, ns
  Duration clock_grace{10'000'000'000};  ///< after the first packet, until a clock must be followed
  double warn_loss = 0.001;              ///< fraction of packets lost over 10 s that is a WARN
  double error_loss = 0.05;              ///< and that is an ERROR

  /// What is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;
};

/// One thing that is wrong with a sensor.
struct Finding {
  const char* id = "";  ///< "silent", "undecodable", "no_sweeps", "loss", "clock", ...
  Level level = Level::kOk;
  Stamp since;         ///< when it was raised
  std::string what;    ///< a sentence
  std::string advice;  ///< what to do
};

/// A finding that appeared or went away at one tick.
struct Transition {
  bool raised = false;
  Finding finding;
};

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

 private:
  static constexpr size_t kWindow = 10;  // snapshots that rates are taken over

  struct Snapshot {
    Stamp stamp;
    SensorCounters counters;
  };
  struct Condition {
    const char* id;
    Level level;
    Hysteresis state;
    std::string what = {};
    std::string advice = {};
  };
  struct Verdict {  // of one condition at one tick
    bool holds = false;
    std::string what = {};
    std::string advice = {};
  };

  void restart_at(Stamp now);
  Verdict judge_silence(Stamp now, const SensorCounters& counters);
  Verdict judge_decoding(const SensorCounters& now, const SensorCounters& before) const;
  Verdict judge_sweeps(Stamp now, const SensorCounters& now_counters);
  Verdict judge_loss(const SensorCounters& now, const SensorCounters& before, double least,
                     double below) const;
  Verdict judge_sender(const SensorCounters& now, const SensorCounters& before) const;
  Verdict judge_model(const SensorCounters& now, const SensorCounters& before) const;
  Verdict judge_clock(Stamp now, const SensorCounters& counters);
  void apply(Condition& condition, Verdict verdict, Stamp now);
  void measure_rates(Stamp now, const Snapshot& oldest);

  std::string endpoint_;
  HealthOptions options_;
  Stamp last_packet_;  // or the start, while there is none
  Stamp last_sweep_;
  Stamp previous_;                   // tick
  std::optional<Stamp> first_seen_;  // tick of the first packet
  uint64_t packets_seen_ = 0;
  uint64_t sweeps_seen_ = 0;
  std::array<Snapshot, kWindow + 1> window_;
  size_t taken_ = 0;
  std::vector<Condition> conditions_;
  SensorStatus status_;
};

}  // namespace infuse::daemon

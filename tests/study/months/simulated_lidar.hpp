#pragma once

#include <random>
#include <string>

#include "daemon/health/lidar_counters.hpp"
#include "drivers/lidar/sender_lock.hpp"
#include "drivers/measurement/clock_model.hpp"
#include "tests/study/months/fault.hpp"
#include "tests/study/months/simulated_host.hpp"

namespace infuse::study {

/// A lidar, its cable and the counters that the intake would have: the clock model, the sender lock
/// and the conversion of the kernel's stamps are the product's, packets are only counted.
///
/// Faults: silent, closed, garbage, loss P, kernel_loss P, stopped, spoofed, forged, swapped,
/// wrong_model, two_sensors, small_buffer, overload, jump S, skew PPM, unlocked, jitter MS, stray,
/// duplicates, late, others.
class SimulatedLidar {
 public:
  SimulatedLidar(std::string name, uint32_t address, uint32_t configured, uint64_t seed);

  /// Begins a run of the daemon.
  void restart(const host::TimeBase& base);

  /// Delivers the second before `host.truth`.
  void deliver(const SimulatedHost& host, const FaultSchedule& faults);

  const daemon::LidarCounters& counters() const { return counters_; }
  /// True if packets came in the last second.
  bool delivers() const { return delivers_; }

 private:
  void apply_events(const SimulatedHost& host, const FaultSchedule& faults);
  void set_source(const FaultSchedule& faults);
  void receive(const SimulatedHost& host, Stamp time, const FaultSchedule& faults);
  void count_rejected(uint64_t& counter, uint64_t datagrams, uint32_t sender);
  bool is_lost(double probability);
  Duration device_time(Stamp time) const;

  std::string name_;
  uint32_t address_, configured_;
  std::mt19937_64 random_;
  Duration device_offset_{0};
  double skew_ppm_ = 12;
  Stamp skew_from_;
  host::WallStamps stamps_{host::TimeBase({0, 0})};
  ClockModel clock_{ClockModelOptions{}};
  lidar::SenderLock lock_{0};
  daemon::LidarCounters counters_;
  uint64_t sent_ = 0;
  bool delivers_ = false;
};

}  // namespace infuse::study

#pragma once

#include <cstdint>
#include <string>

#include "daemon/health/sensor_counters.hpp"
#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/sweep.hpp"
#include "drivers/velodyne/position_packet.hpp"
#include "drivers/velodyne/sweep_assembler.hpp"

namespace infuse::daemon {

/// How the data of one lidar becomes sweeps.
struct LidarSetup {
  std::string name;
  bool has_packets = true;  ///< false: the drive has decoded sweeps
  velodyne::SweepAssemblerOptions assembler;
};

/// One lidar: datagrams in, sweeps out, everything counted. Of the io thread.
class LidarIntake {
 public:
  explicit LidarIntake(const LidarSetup& setup);

  /// Takes a datagram of one of the lidar's ports and calls `on_sweep(Sweep&)` for every sweep that
  /// it completes. The callee may swap the sweep's arrays for others.
  template <class OnSweep>
  void add_datagram(const Datagram& datagram, OnSweep on_sweep) {
    if (datagram.payload.size() == velodyne::kPositionPacketSize)
      return add_position_packet(datagram);
    push(datagram);
    pull(on_sweep);
  }

  /// Takes a sweep that was decoded before.
  template <class OnSweep>
  void add_sweep(const Sweep& sweep, OnSweep on_sweep) {
    sweep_ = sweep;
    note_packet(sweep.stamp);
    ++counters_.packets;
    counters_.clock = sweep.clock;
    complete(on_sweep);
  }

  /// The stream has ended: calls `on_sweep` for what is left.
  template <class OnSweep>
  void finish(OnSweep on_sweep) {
    assembler_.finish();
    pull(on_sweep);
  }

  /// Counts datagrams that the kernel dropped for want of buffer, at a port of data packets or of
  /// position packets.
  void add_kernel_dropped(uint64_t datagrams, bool data) {
    if (data) assembler_.add_kernel_dropped(datagrams);
    counters_.lost_kernel += datagrams;
  }

  /// Up to date after each call.
  const SensorCounters& counters() const { return counters_; }

 private:
  template <class OnSweep>
  void pull(OnSweep on_sweep) {
    while (assembler_.pull(sweep_)) complete(on_sweep);
  }

  template <class OnSweep>
  void complete(OnSweep on_sweep) {
    ++counters_.sweeps;
    counters_.returns += sweep_.size();
    on_sweep(sweep_);
    sweep_.clear();
  }

  void push(const Datagram& datagram);
  void add_position_packet(const Datagram& datagram);
  void note_packet(Stamp stamp);
  void note_unexpected_sender(const Datagram& datagram);

  velodyne::SweepAssembler assembler_;
  Sweep sweep_;  // being filled
  SensorCounters counters_;
  uint64_t refused_positions_ = 0;
};

}  // namespace infuse::daemon

#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "daemon/health/lidar_counters.hpp"
#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/gyro_readings.hpp"
#include "drivers/measurement/sweep.hpp"
#include "drivers/velodyne/model_inference.hpp"
#include "drivers/velodyne/position_packet.hpp"
#include "drivers/velodyne/sweep_assembler.hpp"

namespace infuse::daemon {

/// Options of assembling the sweeps of one lidar.
struct LidarSetup {
  std::string name;
  bool has_packets = true;  ///< false: the drive has decoded sweeps
  velodyne::SweepAssemblerOptions assembler;
};

/// One lidar: datagrams in, sweeps and GNSS fixes out, everything counted. Used by the io thread.
class LidarIntake {
 public:
  explicit LidarIntake(const LidarSetup& setup);

  /// Processes a datagram of one of the lidar's ports. Calls `on_sweep(Sweep&)` for every sweep
  /// that it completes; the callee may swap the sweep's arrays for others. Calls `on_fix(const
  /// GnssFix&)` for a position packet with a new NMEA sentence, and `on_gyros(const GyroReadings&)`
  /// for one of a lidar that has gyros; both have the datagram's stamp.
  template <class OnSweep, class OnFix, class OnGyros>
  void add_datagram(const Datagram& datagram, OnSweep on_sweep, OnFix on_fix, OnGyros on_gyros) {
    if (datagram.payload.size() == velodyne::kPositionPacketSize) {
      const PositionContent content = add_position_packet(datagram);
      if (content.fix) on_fix(*content.fix);
      if (content.gyros) on_gyros(*content.gyros);
      return;
    }
    push(datagram);
    pull(on_sweep);
  }

  /// The same without gyros.
  template <class OnSweep, class OnFix>
  void add_datagram(const Datagram& datagram, OnSweep on_sweep, OnFix on_fix) {
    add_datagram(datagram, on_sweep, on_fix, [](const GyroReadings&) {});
  }

  /// The same without fixes.
  template <class OnSweep>
  void add_datagram(const Datagram& datagram, OnSweep on_sweep) {
    add_datagram(datagram, on_sweep, [](const GnssFix&) {});
  }

  /// Processes a decoded sweep.
  template <class OnSweep>
  void add_sweep(const Sweep& sweep, OnSweep on_sweep) {
    sweep_ = sweep;
    note_packet(sweep.stamp);
    ++counters_.packets;
    counters_.clock = sweep.clock;
    complete(on_sweep);
  }

  /// Ends the stream: calls `on_sweep` for the sweep being assembled.
  template <class OnSweep>
  void finish(OnSweep on_sweep) {
    judge_model();
    assembler_.finish();
    pull(on_sweep);
  }

  /// Counts datagrams that the kernel dropped because the receive buffer was full. `data`: at a
  /// port of data packets, otherwise of position packets.
  void add_kernel_dropped(uint64_t datagrams, bool data) {
    if (data) assembler_.add_kernel_dropped(datagrams);
    counters_.lost_kernel += datagrams;
  }

  /// Counts datagrams that the kernel dropped at a port whose senders it filters, since the buffer
  /// was full or they were not from the sensor: which of them were the sensor's, its own counter
  /// tells.
  void add_filtered(uint64_t datagrams) {
    filtered_ = true;
    assembler_.add_kernel_dropped(datagrams);
  }

  /// Counters, up to date after each call.
  const LidarCounters& counters() const { return counters_; }

 private:
  struct PositionContent {
    std::optional<GnssFix> fix;
    std::optional<GyroReadings> gyros;
  };

  template <class OnSweep>
  void pull(OnSweep on_sweep) {
    while (assembler_.pull(sweep_)) complete(on_sweep);
  }

  template <class OnSweep>
  void complete(OnSweep on_sweep) {
    ++counters_.sweeps;
    if (is_uncalibrated()) ++counters_.uncalibrated_sweeps;
    counters_.returns += sweep_.size();
    on_sweep(sweep_);
    sweep_.clear();
  }

  void push(const Datagram& datagram);
  void judge_model();
  bool is_uncalibrated() const;
  PositionContent add_position_packet(const Datagram& datagram);
  std::optional<GyroReadings> gyro_readings(const Datagram& datagram,
                                            const velodyne::PositionPacket& packet) const;
  std::optional<GnssFix> new_fix(const Datagram& datagram, const velodyne::PositionPacket& packet);
  void note_packet(Stamp stamp);
  void note_unexpected_sender(const Datagram& datagram);

  const velodyne::ModelInfo& model_;
  velodyne::ModelInference inference_;
  uint64_t judged_packets_ = 0;      // at the last judgement
  uint64_t agreeing_sentences_ = 0;  // position packets in a row whose sentence fits the counter
  velodyne::SweepAssembler assembler_;
  Sweep sweep_;  // being assembled
  LidarCounters counters_;
  bool filtered_ = false;  // the kernel reports rejected datagrams as dropped
  uint64_t refused_positions_ = 0;
  uint64_t wrong_sender_positions_ = 0;
  int64_t last_sentence_ns_ = 0;  // UTC of the last NMEA sentence
};

}  // namespace infuse::daemon

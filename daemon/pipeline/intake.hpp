#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>
#include <stop_token>
#include <vector>

#include "daemon/pipeline/drive_ticker.hpp"
#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/pipeline/pacer.hpp"
#include "daemon/pipeline/stream_item.hpp"
#include "drivers/measurement/slot_ring.hpp"
#include "drivers/recording/drive_source.hpp"

namespace infuse::daemon {

/// The io thread of a replay: reads the drive, decodes, assembles sweeps, and hands them over in
/// drive time. Waits for its consumer and drops nothing.
class Intake {
 public:
  /// The ring has its reader already and outlives this, as does the source.
  Intake(recording::DriveSource& source, const std::vector<LidarSetup>& lidars,
         std::optional<double> rate, SlotRing<StreamItem>& out);

  /// Until the drive or the patience ends. The last item is always a kEnd.
  void run(std::stop_token stop);

  /// Bytes of the capture that the datagrams read so far take up; for a progress bar, from any
  /// thread.
  uint64_t capture_bytes() const { return capture_bytes_.load(std::memory_order_relaxed); }

 private:
  void take(const recording::DriveEvent& event);
  void take(const recording::DatagramEvent& event);
  void take(const recording::SweepEvent& event);
  void hand_over_sweep(uint32_t device, Sweep& sweep);
  void hand_over_tick(Stamp stamp);
  void hand_over(StreamItem::Kind kind, Stamp stamp);

  recording::DriveSource& source_;
  std::deque<LidarIntake> lidars_;  // they do not move
  SlotRing<StreamItem>& out_;
  Pacer pacer_;
  DriveTicker ticker_;
  HostClock::time_point taken_;
  LatencyHistogram latency_;
  uint64_t unclaimed_ = 0;      // datagrams that came to no lidar's port
  uint32_t stranger_ = 0;       // the last one's sender
  uint32_t stranger_size_ = 0;  // and payload, bytes
  std::atomic<uint64_t> capture_bytes_{0};
};

}  // namespace infuse::daemon

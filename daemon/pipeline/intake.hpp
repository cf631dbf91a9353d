#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>
#include <stop_token>
#include <vector>

#include "daemon/pipeline/camera_intake.hpp"
#include "daemon/pipeline/drive_setup.hpp"
#include "daemon/pipeline/drive_ticker.hpp"
#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/pipeline/pacer.hpp"
#include "daemon/pipeline/stream_item.hpp"
#include "daemon/pipeline/vehicle_intake.hpp"
#include "drivers/measurement/slot_ring.hpp"
#include "drivers/recording/drive_source.hpp"

namespace infuse::daemon {

/// The io thread of a replay: reads the drive, decodes packets and frames of the bus, assembles
/// sweeps, and hands all of it over in drive time. Waits for its consumers and drops nothing.
class Intake {
 public:
  /// The vehicle's samples are handed over together, so many at most, ...
  static constexpr size_t kSamplesTogether = 64;
  /// ... and within so much drive time.
  static constexpr Duration kSamplesWithin{10'000'000};

  /// The ring has its readers already and outlives this, as does the setup.
  Intake(DriveSetup& setup, std::optional<double> rate, SlotRing<StreamItem>& out);

  /// Until the drive or the patience ends. The last item is always a kEnd.
  void run(std::stop_token stop);

  /// Bytes of the capture that the datagrams read so far take up; for a progress bar, from any
  /// thread.
  uint64_t capture_bytes() const { return capture_bytes_.load(std::memory_order_relaxed); }

  /// What was wrong with the bus's log; after the end.
  const vehicle::ProblemLog& bus_problems() const { return vehicle_.problems(); }

 private:
  void take(const recording::DriveEvent& event);
  void take(const recording::DatagramEvent& event);
  void take(const recording::SweepEvent& event);
  void take(const recording::ImageEvent& event, Stamp stamp);
  void add(const VehicleSample& sample, Stamp stamp);
  void hand_over_samples();
  void hand_over_sweep(uint32_t device, Sweep& sweep);
  void hand_over_tick(Stamp stamp);
  void hand_over(StreamItem::Kind kind, Stamp stamp);

  recording::DriveSource& source_;
  std::deque<LidarIntake> lidars_;  // they do not move
  std::vector<CameraIntake> cameras_;
  VehicleIntake vehicle_;
  std::vector<VehicleSample> samples_;  // not handed over yet
  Stamp first_sample_, last_sample_;    // when the drive came to them
  bool has_can_, has_imu_, has_gps_;
  uint64_t pictures_ = 0;
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

#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <string>

#include "daemon/health/lidar_counters.hpp"
#include "daemon/setup/sensor_setup.hpp"
#include "drivers/lidar/lidar_decoder.hpp"
#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/gyro_readings.hpp"
#include "drivers/measurement/sweep.hpp"
#include "drivers/measurement/vehicle_samples.hpp"

namespace infuse::daemon {

/// One lidar: datagrams in, sweeps and GNSS fixes out, everything counted. Used by the io thread.
class LidarIntake {
 public:
  /// The options of the decoder must be those of which its maker makes one.
  explicit LidarIntake(const LidarSetup& setup);

  /// Processes a datagram of one of the lidar's ports. Calls `on_sweep(Sweep&)` for every sweep
  /// that it completes; the callee may swap the sweep's arrays for others. Calls `on_fix(const
  /// GnssFix&)` for a packet with a new fix of a GNSS receiver, `on_gyros(const GyroReadings&)`
  /// for one of a lidar that has gyros, and `on_imu(const ImuSample&)`, in the vehicle's axes, for
  /// one of a lidar that has an inertial unit.
  template <class OnSweep, class OnFix, class OnGyros, class OnImu>
  void add_datagram(const Datagram& datagram, OnSweep on_sweep, OnFix on_fix, OnGyros on_gyros,
                    OnImu on_imu) {
    push(datagram);
    GnssFix fix;
    if (decoder_->pull(fix)) on_fix(fix);
    GyroReadings readings;
    if (decoder_->pull(readings)) on_gyros(readings);
    ImuSample sample;
    if (decoder_->pull(sample)) on_imu(to_vehicle(sample));
    pull(on_sweep);
  }

  /// The same without gyros and inertial unit.
  template <class OnSweep, class OnFix>
  void add_datagram(const Datagram& datagram, OnSweep on_sweep, OnFix on_fix) {
    add_datagram(
        datagram, on_sweep, on_fix, [](const GyroReadings&) {}, [](const ImuSample&) {});
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
    if (decoder_ == nullptr) return;
    decoder_->finish();
    copy_counters();
    pull(on_sweep);
  }

  /// Counts datagrams that the kernel dropped because the receive buffer was full. `data`: at a
  /// port of data packets, otherwise of position packets.
  void add_kernel_dropped(uint64_t datagrams, bool data);

  /// Counts datagrams that the kernel dropped at a port whose senders it filters, since the buffer
  /// was full or they were not from the sensor: which of them were the sensor's, its own counter
  /// tells.
  void add_filtered(uint64_t datagrams);

  /// Counters, up to date after each call.
  const LidarCounters& counters() const { return counters_; }

 private:
  template <class OnSweep>
  void pull(OnSweep on_sweep) {
    while (decoder_->pull(sweep_)) complete(on_sweep);
  }

  template <class OnSweep>
  void complete(OnSweep on_sweep) {
    ++counters_.sweeps;
    if (decoder_ != nullptr && decoder_->is_uncalibrated()) ++counters_.uncalibrated_sweeps;
    counters_.returns += sweep_.size();
    on_sweep(sweep_);
    sweep_.clear();
  }

  void push(const Datagram& datagram);
  ImuSample to_vehicle(const ImuSample& sample) const;
  void copy_counters();
  void note_packet(Stamp stamp);

  std::unique_ptr<lidar::LidarDecoder> decoder_;  // null if the drive has decoded sweeps
  Eigen::Matrix3d R_vehicle_lidar_;
  LidarCounters counters_;
  Sweep sweep_;
};

}  // namespace infuse::daemon

#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "daemon/pipeline/camera_intake.hpp"
#include "daemon/pipeline/drive_ticker.hpp"
#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/pipeline/pipeline_tap.hpp"
#include "daemon/pipeline/source_states.hpp"
#include "daemon/pipeline/stream_item.hpp"
#include "daemon/pipeline/vehicle_intake.hpp"
#include "daemon/setup/sensor_setup.hpp"
#include "drivers/measurement/slot_ring.hpp"

namespace infuse::daemon {

/// The entry of all sensor data into the pipeline, from a drive (`DriveReader`) or live
/// (`LiveReader`): decodes packets and CAN frames, assembles sweeps, and passes everything on in
/// one order. Used by the io thread.
class Intake {
 public:
  /// Maximum number of vehicle samples that are passed on together.
  static constexpr size_t kMaxSampleBatch = 64;
  /// Maximum drive time that a vehicle sample waits.
  static constexpr Duration kMaxSampleDelay{10'000'000};

  /// The readers of `out` must be registered already; `out` must outlive this object.
  /// `tap` too; null: nobody wants datagrams.
  Intake(const SensorSetup& setup, SlotRing<StreamItem>& out, const PipelineTap* tap = nullptr);

  /// Starts the drive at `stamp`.
  void start(Stamp stamp);
  /// Advances drive time to the event that follows: passes on ticks and notes the host's time.
  void advance(Stamp stamp);
  /// Ends the drive: passes on unfinished sweeps and samples, a last tick, and kEnd, after which
  /// nothing follows. `started`: false if there was no event.
  void end(Stamp stamp, bool started = true);

  // --- events, by index of the sensor ---

  void add_datagram(LidarIndex lidar, const Datagram& datagram);
  /// Counts a datagram to a port that no lidar uses.
  void add_unclaimed_datagram(const Datagram& datagram);
  void add_sweep(LidarIndex lidar, const Sweep& sweep);
  void add_image_file(CameraIndex camera, Stamp stamp, uint64_t sequence,
                      const std::filesystem::path& path);
  void add_streamed_image(CameraIndex camera, const camera::StreamedImage& image);
  void add_can_line(std::string_view line, Stamp stamp);
  void add_can_frame(BusIndex bus, const vehicle::CanFrame& frame);
  void add_speed(const WheelOdometry& sample, Stamp stamp);
  void add_imu(const ImuSample& sample, Stamp stamp);
  void add_gnss(const GnssFix& fix, Stamp stamp);

  /// Passes on the vehicle samples that are due at `now`.
  void push_due_samples(Stamp now);

  /// Counts datagrams that the kernel dropped because the receive buffer was full. `data`: at a
  /// port of data packets, otherwise of position packets.
  void add_kernel_dropped(LidarIndex lidar, uint64_t datagrams, bool data) {
    lidars_[lidar].add_kernel_dropped(datagrams, data);
  }

  /// The same at a port of data packets whose senders the kernel filters.
  void add_filtered(LidarIndex lidar, uint64_t datagrams) {
    lidars_[lidar].add_filtered(datagrams);
  }

  /// State of the live sources, updated by the reader. Default in a replay.
  SourceStates& sources() { return sources_; }

  /// Problems of the CAN log; valid after the end.
  const vehicle::ProblemLog& bus_problems() const { return vehicle_.problems(); }

 private:
  void add_vehicle_sample(const VehicleSample& sample, Stamp stamp, bool from_bus);
  void keep_datagram(LidarIndex lidar, const Datagram& datagram);
  void push_datagrams(LidarIndex lidar);
  void push_samples();
  void push_sweep(LidarIndex lidar, Sweep& sweep);
  void push_image(CameraIndex camera, Stamp stamp, uint64_t sequence);
  void push_tick(Stamp stamp);
  void push_item(StreamItem::Kind kind, Stamp stamp);

  Delivery delivery_;
  std::deque<LidarIntake> lidars_;  // a deque: elements do not move
  std::vector<CameraIntake> cameras_;
  size_t mounted_cameras_;  // images of further cameras are only counted
  VehicleIntake vehicle_;
  std::optional<LidarIndex> gnss_lidar_;  // whose position packets carry the GNSS fixes
  SourceStates sources_;
  std::vector<VehicleSample> samples_;  // not passed on yet
  std::vector<uint8_t> from_bus_;       // by sample: 1 if it is from a bus
  Stamp first_sample_, last_sample_;    // drive time of the first and the last of these
  uint64_t image_count_ = 0;
  SlotRing<StreamItem>& out_;
  const PipelineTap* tap_;
  std::vector<std::vector<uint8_t>> datagrams_;  // by lidar, not passed on yet
  std::vector<Stamp> last_datagrams_;            // stamps of the last of these
  DriveTicker ticker_;
  HostClock::time_point read_at_;
  LatencyHistogram latency_;
  uint64_t unclaimed_ = 0;          // datagrams to a port that no lidar uses
  uint32_t unexpected_sender_ = 0;  // sender of the last one
  uint32_t unexpected_size_ = 0;    // payload size of the last one, bytes
};

}  // namespace infuse::daemon

#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <string_view>
#include <vector>

#include "daemon/pipeline/camera_intake.hpp"
#include "daemon/pipeline/drive_ticker.hpp"
#include "daemon/pipeline/lidar_intake.hpp"
#include "daemon/pipeline/pipeline_setup.hpp"
#include "daemon/pipeline/source_states.hpp"
#include "daemon/pipeline/stream_item.hpp"
#include "daemon/pipeline/vehicle_intake.hpp"
#include "drivers/measurement/slot_ring.hpp"

namespace infuse::daemon {

/// Where all that the sensors say enters the pipeline, of a drive (`DriveReader`) or live
/// (`LiveReader`): decodes packets and frames of the buses, assembles sweeps, and hands all of it
/// over. Of the io thread.
class Intake {
 public:
  /// The vehicle's samples are handed over together, so many at most, ...
  static constexpr size_t kMaxSampleBatch = 64;
  /// ... and within so much drive time.
  static constexpr Duration kMaxSampleDelay{10'000'000};

  /// The ring has its readers already and outlives this.
  Intake(const PipelineSetup& setup, SlotRing<StreamItem>& out);

  /// Begins, in drive time.
  void start(Stamp stamp);
  /// Drive time has come to the next event, which is taken next: ticks, and notes the host's time.
  void advance(Stamp stamp);
  /// Finishes what is begun, ticks once more when that is worked off, and hands over kEnd, after
  /// which nothing follows. `started` false: there was nothing.
  void end(Stamp stamp, bool started = true);

  // --- events, of sensors by their index ---

  void add_datagram(LidarIndex lidar, const Datagram& datagram);
  /// A datagram that came to no lidar's port.
  void add_unclaimed_datagram(const Datagram& datagram);
  void add_sweep(LidarIndex lidar, const Sweep& sweep);
  void add_image_file(CameraIndex camera, Stamp stamp, uint64_t sequence,
                      const std::filesystem::path& path);
  void add_streamed_image(CameraIndex camera, const camera::StreamedImage& image);
  void add_can_line(std::string_view line, Stamp stamp);
  void add_can_frame(BusIndex bus, const vehicle::CanFrame& frame);
  void add_imu(const ImuSample& sample, Stamp stamp);
  void add_gnss(const GnssFix& fix, Stamp stamp);

  /// Hands over the vehicle's samples that have waited long enough at `now`.
  void push_due_samples(Stamp now);

  /// Datagrams that the kernel dropped for want of buffer, `data`: at a port of data packets.
  void add_kernel_dropped(LidarIndex lidar, uint64_t datagrams, bool data) {
    lidars_[lidar].add_kernel_dropped(datagrams, data);
  }

  /// How the live sources are; the reader keeps it up to date. Empty in a replay.
  SourceStates& sources() { return sources_; }

  /// What was wrong with the bus's log; after the end.
  const vehicle::ProblemLog& bus_problems() const { return vehicle_.problems(); }

 private:
  void add_vehicle_sample(const VehicleSample& sample, Stamp stamp);
  void push_samples();
  void push_sweep(LidarIndex lidar, Sweep& sweep);
  void push_image(CameraIndex camera, Stamp stamp, uint64_t sequence);
  void push_tick(Stamp stamp);
  void push_item(StreamItem::Kind kind, Stamp stamp);

  Delivery delivery_;
  std::deque<LidarIntake> lidars_;  // they do not move
  std::vector<CameraIntake> cameras_;
  size_t mounted_cameras_;  // images of further cameras are only counted
  VehicleIntake vehicle_;
  SourceStates sources_;
  std::vector<VehicleSample> samples_;  // not handed over yet
  Stamp first_sample_, last_sample_;    // when the drive came to them
  uint64_t image_count_ = 0;
  SlotRing<StreamItem>& out_;
  DriveTicker ticker_;
  HostClock::time_point read_at_;
  LatencyHistogram latency_;
  uint64_t unclaimed_ = 0;          // datagrams that came to no lidar's port
  uint32_t unexpected_sender_ = 0;  // the last one's sender
  uint32_t unexpected_size_ = 0;    // and payload, bytes
};

}  // namespace infuse::daemon

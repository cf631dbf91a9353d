#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/health/latency_histogram.hpp"
#include "daemon/pipeline/vehicle_sample.hpp"
#include "daemon/setup/sensor_table.hpp"
#include "drivers/camera/raw_image.hpp"
#include "drivers/measurement/stamp.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::daemon {

/// Clock of the host for latencies; not used in the reports of a replay.
using HostClock = std::chrono::steady_clock;

/// An item from the io thread to the other threads, in the order of the drive. One ring carries all
/// items, so that the order of reports does not depend on the timing of threads.
struct StreamItem {
  enum class Kind : uint8_t {
    kStart,      ///< start of the drive; stamp: its first event
    kSamples,    ///< `samples`; stamp: of the last one
    kImage,      ///< `camera`, `number`, `sequence` and `encoded`; stamp: middle of the exposure
    kSweep,      ///< `lidar` and `sweep`
    kDatagrams,  ///< `lidar` and `datagrams`, as a `PipelineTap` wants them; nobody else reads them
    kTick,       ///< a second of drive time has passed: `counters`
    kFlush,      ///< no more samples, images and sweeps: waiting ones are processed
    kEnd,        ///< end of the drive; nothing follows
  };
  Kind kind = Kind::kStart;
  /// True if it says how the drive goes on: it reaches a consumer that has lost data.
  bool is_control() const {
    return kind == Kind::kStart || kind == Kind::kTick || kind == Kind::kFlush ||
           kind == Kind::kEnd;
  }
  Stamp stamp;
  HostClock::time_point read_at;  ///< time at which the event that completed it was read

  std::vector<VehicleSample> samples;
  /// For each sample: 1: decoded from a bus; 0: from a sensor of its own.
  std::vector<uint8_t> from_bus;

  CameraIndex camera;                        ///< of the image
  uint64_t number = 0;                       ///< number of the image among all cameras, from 0
  uint64_t sequence = 0;                     ///< sequence number of the image in its camera
  std::vector<uint8_t> encoded;              ///< bytes of the image file or of the camera
  std::optional<camera::StreamedImage> raw;  ///< layout of a camera's bytes; nothing: a file

  LidarIndex lidar;  ///< of the sweep
  Sweep sweep;
  std::vector<uint8_t> datagrams;  ///< `for_each_datagram`

  SensorCounters counters;
  LatencyStats intake;  ///< latency of the io thread
};

}  // namespace infuse::daemon

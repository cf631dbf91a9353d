#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/health/latency_histogram.hpp"
#include "daemon/health/lidar_counters.hpp"
#include "daemon/health/stream_counters.hpp"
#include "daemon/pipeline/sensor_index.hpp"
#include "daemon/pipeline/vehicle_sample.hpp"
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
    kTick,       ///< a second of drive time has passed: `counters` and `streams`
    kFlush,      ///< no more samples, images and sweeps: waiting ones are processed
    kEnd,        ///< end of the drive; nothing follows
  };
  Kind kind = Kind::kStart;
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

  std::vector<LidarCounters> counters;  ///< by LidarIndex
  std::vector<StreamCounters> streams;  ///< cameras, then vehicle sensors
  LatencyStats intake;                  ///< latency of the io thread
};

}  // namespace infuse::daemon

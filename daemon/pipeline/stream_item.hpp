#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/health/latency_histogram.hpp"
#include "daemon/health/sensor_counters.hpp"
#include "daemon/health/stream_counters.hpp"
#include "daemon/pipeline/vehicle_sample.hpp"
#include "drivers/camera/raw_image.hpp"
#include "drivers/measurement/stamp.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::daemon {

/// The host's clock for latencies; never in a report that a replay must repeat.
using HostClock = std::chrono::steady_clock;

/// What the io thread hands to the other threads, in the order in which the drive has it. One ring
/// carries all of it, so that what fusion reports is in one order, whatever the threads do.
struct StreamItem {
  enum class Kind : uint8_t {
    kStart,    ///< of the drive; stamp: its first event
    kSamples,  ///< `samples` of the vehicle; stamp: the last one's
    kImage,    ///< `camera`, `number`, `sequence` and `encoded`; stamp: middle of the exposure
    kSweep,    ///< `device` and `sweep`
    kTick,     ///< a second of drive time has passed: `counters` and `streams`
    kFlush,    ///< no more samples, pictures and sweeps: those that wait are worked off
    kEnd,      ///< of the drive; nothing follows
  };
  Kind kind = Kind::kStart;
  Stamp stamp;
  HostClock::time_point read_at;  ///< when the event that completed it was read

  std::vector<VehicleSample> samples;

  uint32_t camera = 0;                       ///< index in the rig
  uint64_t number = 0;                       ///< counts the pictures of all cameras from 0
  uint64_t sequence = 0;                     ///< the camera's own count
  std::vector<uint8_t> encoded;              ///< the picture as its file or its camera has it
  std::optional<camera::StreamedImage> raw;  ///< how the camera lays it out, without the bytes;
                                             ///< nothing: a file

  uint32_t device = 0;  ///< lidar, index in the rig
  Sweep sweep;

  std::vector<SensorCounters> counters;  ///< by lidar
  std::vector<StreamCounters> streams;   ///< by stream: cameras, then the vehicle's sensors
  LatencyStats intake;                   ///< of the io thread
};

}  // namespace infuse::daemon

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "daemon/health/odometry_health.hpp"
#include "daemon/health/sensor_counters.hpp"
#include "daemon/health/stream_counters.hpp"
#include "daemon/health/streetmap_health.hpp"
#include "daemon/pipeline/stream_item.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// The stages whose latency is measured.
enum class Stage : uint8_t {
  kIntake,   ///< an event read to its sweep or picture handed over
  kDecode,   ///< one picture decoded
  kDeskew,   ///< one sweep made straight and summarised
  kProject,  ///< one picture and its sweep brought together
  kTrack,    ///< one sweep or picture taken by the street-map tracker
  kMonitor,  ///< the calibration watched with them
  kTotal,    ///< the event that completed a sweep read to the sweep's report
  kCount,
};

inline constexpr std::array<const char*, static_cast<size_t>(Stage::kCount)> kStageNames = {
    "intake", "decode", "straight", "project", "track", "watch", "whole"};

/// What the fusion thread hands to the thread that tells: values of fixed size, not yet text.
struct ReportItem {
  enum class Kind : uint8_t {
    kStart,        ///< of the drive
    kSweep,        ///< `sweep`
    kPose,         ///< `pose`
    kFrame,        ///< `frame`
    kCalibration,  ///< `calibration`
    kTick,         ///< the rest
    kEnd,          ///< of the drive; nothing follows
  };
  Kind kind = Kind::kStart;
  Stamp stamp;
  SweepReport sweep;
  PoseReport pose;
  FrameReport frame;
  CalibrationReport calibration;
  std::vector<SensorCounters> counters;  ///< by lidar
  std::vector<StreamCounters> streams;   ///< by stream
  OdometryStatus odometry;
  StreetMapStatus streetmap;
  std::array<LatencyStats, static_cast<size_t>(Stage::kCount)> stages{};
  uint64_t deadline_misses = 0;  ///< sweeps whose `kTotal` was above the budget
  QueueStats items_waiting;      ///< between the io thread and fusion
};

}  // namespace infuse::daemon

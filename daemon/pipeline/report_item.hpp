#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "daemon/health/odometry_health.hpp"
#include "daemon/health/sensor_counters.hpp"
#include "daemon/health/stream_counters.hpp"
#include "daemon/pipeline/stream_item.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// The stages whose latency is measured.
enum class Stage : uint8_t {
  kIntake,    ///< an event read to its sweep or picture handed over
  kDecode,    ///< one picture decoded
  kStraight,  ///< one sweep made straight and summarised
  kProject,   ///< one picture and its sweep brought together
  kWatch,     ///< the calibration watched with them
  kWhole,     ///< the event that completed a sweep read to the sweep's report
  kCount,
};

inline constexpr std::array<const char*, static_cast<size_t>(Stage::kCount)> kStageNames = {
    "intake", "decode", "straight", "project", "watch", "whole"};

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
  OdometryFigures odometry;
  std::array<LatencyFigures, static_cast<size_t>(Stage::kCount)> stages{};
  uint64_t deadline_misses = 0;  ///< sweeps whose `kWhole` was above the budget
  QueueFigures items_waiting;    ///< between the io thread and fusion
};

}  // namespace infuse::daemon

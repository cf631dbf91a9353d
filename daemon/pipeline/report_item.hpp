#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/health/odometry_health.hpp"
#include "daemon/health/streetmap_health.hpp"
#include "daemon/pipeline/stream_item.hpp"
#include "daemon/protocol/reports.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// The stages: steps of the pipeline whose latency is measured.
enum class Stage : uint8_t {
  kIntake,    ///< reading of an event to publishing of its sweep or image
  kDecode,    ///< decoding of an image
  kDeskew,    ///< deskewing of a sweep
  kRegister,  ///< lidar odometry with a sweep
  kProject,   ///< projection of a sweep into an image
  kTrack,     ///< update of the street-map tracker with a sweep or an image
  kMonitor,   ///< monitoring of a calibration with an image
  kTotal,     ///< reading of the event that made a sweep due, as its odometry, to its last report
  kCount,
};

inline constexpr std::array<const char*, static_cast<size_t>(Stage::kCount)> kStageNames = {
    "intake", "decode", "deskew", "register", "project", "track", "monitor", "total"};

/// An item from the fusion thread to the publisher: values of fixed size, not yet text.
struct ReportItem {
  enum class Kind : uint8_t {
    kStart,        ///< start of the drive
    kSweep,        ///< `sweep`
    kPose,         ///< `pose`
    kFrame,        ///< `frame`
    kCalibration,  ///< `calibration`
    kTick,         ///< the rest
    kEnd,          ///< end of the drive; nothing follows
  };
  Kind kind = Kind::kStart;
  /// As `StreamItem::is_control`.
  bool is_control() const {
    return kind == Kind::kStart || kind == Kind::kTick || kind == Kind::kEnd;
  }
  Stamp stamp;
  SweepReport sweep;
  PoseReport pose;
  FrameReport frame;
  CalibrationReport calibration;
  SensorCounters counters;
  OdometryStatus odometry;
  std::optional<StreetMapStatus> streetmap;  ///< nothing: no street map
  std::optional<MapStatus> map;  ///< localisation on the map of keyframes; nothing without one
  std::array<LatencyStats, static_cast<size_t>(Stage::kCount)> stages{};
  uint64_t deadline_misses = 0;        ///< number of sweeps whose `kTotal` exceeded the budget
  uint64_t skipped_registrations = 0;  ///< live: sweeps that were too late to be registered
  QueueStats items_waiting;            ///< queue from the io thread to fusion
};

}  // namespace infuse::daemon

#pragma once

#include <map>
#include <string>
#include <vector>

#include "daemon/pipeline/report_item.hpp"
#include "daemon/protocol/reports.hpp"

namespace infuse::daemon {

/// Totals of a drive.
struct Totals {
  bool started = false;  ///< false: the drive was empty
  bool ended = false;
  Stamp start, now;                                       ///< drive time
  uint64_t alerts = 0;                                    ///< number of raised alerts
  std::vector<AlertReport> first_alerts;                  ///< the first of these
  SensorCounters counters;                                ///< at the last tick
  uint64_t sweeps = 0;                                    ///< number of SWEEP reports
  uint64_t deskewed_sweeps = 0;                           ///< of these, deskewed
  const char* deskew_reason = "";                         ///< why the last other one is not
  uint64_t frames = 0;                                    ///< number of FRAME reports
  uint64_t matched_frames = 0;                            ///< of these, matched with a sweep
  OdometryStatus odometry;                                ///< at the last tick
  std::map<std::string, CalibrationReport> calibrations;  ///< the last of each camera
  std::map<std::string, Level> calibration_levels;        ///< at the last report of each
  SensorLevels levels;                                    ///< at the last tick
  HostStats host;

  Totals() = default;
  explicit Totals(const SensorSetup& setup) : counters(setup), levels(setup) {}

  /// Starts the drive.
  void start_at(Stamp stamp);

  void count(const SweepReport& report);
  void count(const FrameReport& report);
  void count(const AlertReport& report);

  /// Keeps what a tick reports.
  void update(const ReportItem& tick, const SensorLevels& sensor_levels);
};

}  // namespace infuse::daemon

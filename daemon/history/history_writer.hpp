#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>

#include "daemon/history/history_file.hpp"
#include "daemon/protocol/json.hpp"
#include "daemon/protocol/reports.hpp"

namespace infuse::daemon {

/// Writes what is worth knowing after months: each calibration that is in use, raised alerts, and a
/// summary of health every hour. An alert that comes again within the hour is only counted, so that
/// a flapping sensor does not fill the file. While its disk fails the lines wait in memory. Runs on
/// the thread of the `io_context`.
class HistoryWriter {
 public:
  /// Drive time of one summary.
  static constexpr Duration kPeriod{3'600'000'000'000};

  /// `folder`: the state directory; empty: nothing is written.
  explicit HistoryWriter(const std::filesystem::path& folder)
      : file_(folder / kHistoryFile), enabled_(!folder.empty()) {}

  void add(const AlertReport& alert);
  void add(const CalibrationReport& report);
  /// Once a second.
  void add(const HealthReport& health);

  /// Writes the summary of the current hour; called at the end of the run.
  void finish();

  /// Why the history could not be written last; empty if it could.
  const std::string& problem() const { return problem_; }

 private:
  struct Sums {
    Stamp from, to;
    std::map<std::string, uint64_t> seconds;  // by level
  };
  struct Sensor {
    uint64_t sweeps = 0, lost = 0;
  };

  static constexpr size_t kMaxWaiting = 1000;  // number of lines

  void write(const Json& entry);
  void write_waiting();
  void write_summary();

  HistoryFile file_;
  bool enabled_;
  std::deque<std::string> waiting_;  // lines that could not be written yet
  uint64_t lost_ = 0;                // lines for which there was no room to wait
  std::string problem_;
  std::map<std::string, Eigen::Isometry3d> calibrations_;  // written last, by camera
  std::optional<Sums> sums_;
  std::map<std::string, uint64_t> alerts_;       // of this hour, by id
  std::map<std::string, Sensor> now_, written_;  // counters since the start, by lidar
};

}  // namespace infuse::daemon

#pragma once

#include <string>
#include <vector>

#include "daemon/protocol/report_class.hpp"

namespace infuse::daemon {

/// The reports since the start, for a page that is opened later: alerts, and the others ever more
/// coarsely as a drive becomes long.
class ReportStore {
 public:
  /// `max_bytes`: of all lines.
  explicit ReportStore(size_t max_bytes) : max_bytes_(max_bytes) {}

  /// Whether reports of the class are kept: DEVICES, HEALTH, CALIBRATION, ALERT.
  static bool wants(ReportClass report_class);

  /// Adds a line of JSON. Beyond `max_bytes`, every second line of the older half is dropped that
  /// is not an alert; where that does not suffice, the older half.
  void add(ReportClass report_class, std::string line);

  /// All lines in their order, each ended by a line feed but the last.
  std::string text() const;

  bool empty() const { return lines_.empty(); }

 private:
  struct Line {
    ReportClass report_class;
    std::string text;
  };

  void thin();

  size_t max_bytes_, bytes_ = 0;
  std::vector<Line> lines_;
};

}  // namespace infuse::daemon

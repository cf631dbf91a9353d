#pragma once

#include <memory>
#include <string>
#include <vector>

#include "daemon/protocol/report_class.hpp"

namespace infuse::daemon {

/// One line of JSON with its line feed, shared by all clients that it goes to.
using Line = std::shared_ptr<const std::string>;

/// The last report of every class and sensor.
class LastValues {
 public:
  struct Entry {
    ReportClass report_class;
    std::string device;  ///< empty where the report is not of one sensor
    Line line;
  };

  /// Replaces the last of this class and device.
  void set(ReportClass report_class, const std::string& device, Line line);

  /// In the order in which the pairs first appeared.
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<Entry> entries_;  // a few: sensors times classes
};

}  // namespace infuse::daemon

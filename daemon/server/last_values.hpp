#pragma once

#include <memory>
#include <string>
#include <vector>

#include "daemon/protocol/report_class.hpp"

namespace infuse::daemon {

/// A line of JSON with its line feed, shared by the clients that receive it.
using Line = std::shared_ptr<const std::string>;

/// Last report of every class and device.
class LastValues {
 public:
  struct Entry {
    ReportClass report_class;
    std::string device;  ///< empty if the report is not of one device
    Line line;
  };

  /// Replaces the last report of this class and device.
  void set(ReportClass report_class, const std::string& device, Line line);

  /// Entries in the order in which their class and device first appeared.
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<Entry> entries_;  // few: devices times classes
};

}  // namespace infuse::daemon

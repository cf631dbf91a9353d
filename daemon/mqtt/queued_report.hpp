#pragma once

#include <cstdint>
#include <string>

namespace infuse::daemon {

/// A message for the broker.
struct QueuedReport {
  int64_t id = 0;      ///< rises with every message; kept over restarts
  int importance = 0;  ///< of a full queue the least important are dropped first
  std::string topic;
  std::string payload;
  bool retain = false;

  /// Of topic and payload.
  uint64_t bytes() const { return topic.size() + payload.size(); }
};

}  // namespace infuse::daemon

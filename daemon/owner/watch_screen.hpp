#pragma once

#include <map>
#include <string>
#include <utility>

#include "daemon/protocol/json.hpp"

namespace infuse::daemon {

/// What the daemon last reported, as a screen of text: `infuse watch --tui`. Pure.
class WatchScreen {
 public:
  /// Adds a message of the daemon.
  void add(const Json& message);

  /// Returns `rows` lines of at most `columns` characters, joined by line ends: level and time,
  /// alerts, poses, calibrations with their evidence against the threshold, sensors. What does not
  /// fit is left out from the end, and said. Control characters are replaced.
  std::string text(size_t columns, size_t rows) const;

 private:
  Json health_;
  std::map<std::string, Json> poses_;                           // by frame
  std::map<std::string, Json> calibrations_;                    // by camera
  std::map<std::pair<std::string, std::string>, Json> alerts_;  // raised, by device and id
};

}  // namespace infuse::daemon

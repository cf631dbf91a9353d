#pragma once

#include <map>
#include <string>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Decides whether an alert is recorded: a sensor that comes and goes makes one recording, not
/// twenty.
class AlertPause {
 public:
  /// True if `cause` was not recorded within `pause` before `now`. A step back of time ends it.
  bool is_over(const std::string& cause, Stamp now, Duration pause) const {
    const auto found = recorded_.find(cause);
    return found == recorded_.end() || now < found->second || now - found->second >= pause;
  }

  /// Notes that `cause` is recorded at `now`.
  void begin(const std::string& cause, Stamp now) { recorded_[cause] = now; }

 private:
  std::map<std::string, Stamp> recorded_;  // by cause, of which there are few
};

}  // namespace infuse::daemon

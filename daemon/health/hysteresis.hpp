#pragma once

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// A condition that is raised only when it has held for a while, and cleared only when it has been
/// absent for a while.
class Hysteresis {
 public:
  Hysteresis(Duration raise_after, Duration clear_after)
      : raise_after_(raise_after), clear_after_(clear_after) {}

  /// Returns whether the condition is raised at `now`, given whether it holds at `now`. Calls are
  /// in order of time.
  bool update(bool holds, Stamp now) {
    if (holds == raised_) {
      changing_ = false;
      return raised_;
    }
    if (!changing_) {
      changing_ = true;
      changing_since_ = now;
    }
    if (now - changing_since_ >= (holds ? raise_after_ : clear_after_)) {
      raised_ = holds;
      changing_ = false;
      if (raised_) raised_since_ = now;
    }
    return raised_;
  }

  bool raised() const { return raised_; }

  /// Time at which it was last raised; valid while `raised()`.
  Stamp raised_since() const { return raised_since_; }

 private:
  Duration raise_after_;
  Duration clear_after_;
  bool raised_ = false;
  bool changing_ = false;
  Stamp changing_since_;
  Stamp raised_since_;
};

}  // namespace infuse::daemon

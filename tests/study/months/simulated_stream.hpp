#pragma once

#include <string>

#include "daemon/health/stream_counters.hpp"
#include "tests/study/months/fault.hpp"
#include "tests/study/months/simulated_host.hpp"

namespace infuse::study {

/// A camera, a bus or a GNSS receiver, as the daemon counts what it delivers.
///
/// Faults: silent, closed, unreadable (none can be read), torn P (that share cannot), lost P,
/// unused, out_of_order, bus_off, error_passive, down.
class SimulatedStream {
 public:
  SimulatedStream(std::string name, int rate) : name_(std::move(name)), rate_(rate) {}

  /// Begins a run of the daemon.
  void restart() {
    counters_ = {};
    counters_.source.open_count = 1;
  }

  /// Delivers the second before `now`, by the daemon's time.
  void deliver(Stamp now, const FaultSchedule& faults) {
    delivers_ = false;
    set_source(faults);
    if (!counters_.source.open || faults.has(name_, "silent") || faults.has(name_, "bus_off")) {
      return;
    }
    const Fault* torn = faults.find(name_, "torn");
    const Fault* lost = faults.find(name_, "lost");
    for (int i = 0; i < rate_; ++i) {
      const double share = (i + 0.5) / rate_;
      Stamp stamp = now - from_seconds(1) + from_seconds(share);
      if (lost != nullptr && share < lost->value) {
        ++counters_.lost;
        continue;
      }
      if (i == 1 && faults.has(name_, "out_of_order")) stamp -= from_seconds(2.0 / rate_);
      counters_.count(stamp);
      const bool bad = faults.has(name_, "unreadable") || (torn != nullptr && share < torn->value);
      if (bad) {
        ++counters_.refused;
      } else if (!faults.has(name_, "unused")) {
        ++counters_.used;
      }
    }
    delivers_ =
        counters_.source.open && !faults.has(name_, "unreadable") && !faults.has(name_, "unused");
  }

  const daemon::StreamCounters& counters() const { return counters_; }
  /// True if usable data came in the last second.
  bool delivers() const { return delivers_; }

 private:
  void set_source(const FaultSchedule& faults) {
    daemon::SourceState& source = counters_.source;
    const bool down = faults.has(name_, "down");
    const bool closed = faults.has(name_, "closed") || down;
    if (source.open && closed) {
      source.set_problem(down ? "can0: the interface is down" : "no such device");
    }
    if (!source.open && !closed) ++source.open_count;
    source.open = !closed;
    source.bus_off = faults.has(name_, "bus_off");
    source.bus_state = faults.has(name_, "error_passive") ? "error-passive" : "";
  }

  std::string name_;
  int rate_;
  daemon::StreamCounters counters_;
  bool delivers_ = false;
};

}  // namespace infuse::study

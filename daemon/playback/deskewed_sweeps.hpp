#pragma once

#include <deque>
#include <functional>
#include <vector>

#include "daemon/pipeline/odometry_tracker.hpp"
#include "fusion/motion/deskew.hpp"

namespace infuse::daemon {

/// Deskews the sweeps of one lidar of a recording as the daemon does: each sweep waits until
/// odometry covers its time span.
class DeskewedSweeps {
 public:
  /// Returns the time that a sweep is deskewed to.
  using Reference = std::function<Stamp(const Sweep&)>;

  DeskewedSweeps(const Eigen::Isometry3d& T_vehicle_lidar, const OdometrySettings& settings,
                 Reference reference = end_of)
      : odometry_(settings, false),
        max_wait_(settings.max_wait),
        deskewer_(T_vehicle_lidar),
        reference_(std::move(reference)) {}

  static Stamp end_of(const Sweep& sweep) { return sweep.stamp + sweep.span; }

  void add_sample(const VehicleSample& sample) { odometry_.add(sample); }
  void add_sweep(const Sweep& sweep) { waiting_.push_back(sweep); }

  /// Calls `on_sweep(const Sweep&, const DeskewedSweep&)` for every sweep that is due at the drive
  /// time `now`; x, y and z are deskewed to the reference.
  template <class OnSweep>
  void process_due(Stamp now, OnSweep on_sweep) {
    while (!waiting_.empty() && is_due(waiting_.front(), now)) {
      const Sweep& sweep = waiting_.front();
      deskewer_.deskew(sweep, odometry_.trajectory(), reference_(sweep), deskewed_);
      on_sweep(sweep, deskewed_);
      waiting_.pop_front();
    }
  }

  /// Does the same for all remaining sweeps at the end of the recording.
  template <class OnSweep>
  void finish(OnSweep on_sweep) {
    odometry_.finish();
    process_due(Stamp::latest(), on_sweep);
  }

 private:
  bool is_due(const Sweep& sweep, Stamp now) const {
    const Stamp end = end_of(sweep);
    return now - end >= max_wait_ ||
           *odometry_.trajectory().uncovered_reason(sweep.stamp, end) == '\0';
  }

  OdometryTracker odometry_;
  Duration max_wait_;
  motion::Deskewer deskewer_;
  Reference reference_;
  motion::DeskewedSweep deskewed_;
  std::deque<Sweep> waiting_;
};

}  // namespace infuse::daemon

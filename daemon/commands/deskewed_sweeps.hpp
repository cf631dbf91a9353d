#pragma once

#include <deque>
#include <vector>

#include "daemon/pipeline/odometry_tracker.hpp"
#include "fusion/motion/deskew.hpp"

namespace infuse::daemon {

/// Deskews the sweeps of one lidar of a recording as the daemon does: each sweep waits until
/// odometry covers its time span.
class DeskewedSweeps {
 public:
  /// `reference`: the time that sweeps are deskewed to, 0 (start) … 1 (end of the sweep).
  DeskewedSweeps(const Eigen::Isometry3d& T_vehicle_lidar, const OdometrySettings& settings,
                 double reference = 1)
      : odometry_(settings, false),
        max_wait_(settings.max_wait),
        deskewer_(T_vehicle_lidar),
        reference_(reference) {}

  void add_sample(const VehicleSample& sample) { odometry_.add(sample); }
  void add_sweep(const Sweep& sweep) { waiting_.push_back(sweep); }

  /// Calls `on_sweep(const Sweep&, const DeskewedSweep&)` for every sweep that is due at the drive
  /// time `now`; x, y and z are deskewed to the reference.
  template <class OnSweep>
  void process_due(Stamp now, OnSweep on_sweep) {
    while (!waiting_.empty() && is_due(waiting_.front(), now)) {
      const Sweep& sweep = waiting_.front();
      deskewer_.deskew(sweep, odometry_.trajectory(), reference_stamp(sweep), deskewed_);
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
    const Stamp end = sweep.stamp + sweep.span;
    return now - end >= max_wait_ ||
           *odometry_.trajectory().uncovered_reason(sweep.stamp, end) == '\0';
  }

  Stamp reference_stamp(const Sweep& sweep) const {
    return sweep.stamp +
           Duration(static_cast<int64_t>(reference_ * static_cast<double>(sweep.span.count())));
  }

  OdometryTracker odometry_;
  Duration max_wait_;
  motion::Deskewer deskewer_;
  double reference_;
  motion::DeskewedSweep deskewed_;
  std::deque<Sweep> waiting_;
};

}  // namespace infuse::daemon

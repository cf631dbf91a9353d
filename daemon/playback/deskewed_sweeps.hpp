#pragma once

#include <deque>
#include <functional>
#include <optional>

#include "daemon/pipeline/lidar_motion.hpp"

namespace infuse::daemon {

/// Deskews the sweeps of one lidar of a recording as the daemon does, by the same sensors: each
/// sweep waits until they cover its time span, is deskewed by prediction, registered where the
/// lidar measures the motion, and deskewed by what odometry then knows.
class DeskewedSweeps {
 public:
  /// Returns the time that a sweep is deskewed to.
  using Reference = std::function<Stamp(const Sweep&)>;

  /// The settings are those of `plan_odometry`.
  DeskewedSweeps(const OdometrySettings& settings, const Eigen::Isometry3d& T_vehicle_lidar,
                 Reference reference = end_of);

  static Stamp end_of(const Sweep& sweep) { return sweep.stamp + sweep.span; }

  void add_sample(const VehicleSample& sample) { odometry_.add(sample); }
  void add_sweep(const Sweep& sweep);

  /// Calls `on_sweep(const Sweep&, const DeskewedSweep&)` for every sweep that is due at the drive
  /// time `now`; x, y and z are deskewed to the reference.
  template <class OnSweep>
  void process_due(Stamp now, OnSweep on_sweep) {
    while (!waiting_.empty() && is_due(waiting_.front(), now)) {
      process(waiting_.front());
      on_sweep(waiting_.front(), deskewed_);
      waiting_.pop_front();
    }
  }

  /// Does the same for all remaining sweeps at the end of the recording.
  template <class OnSweep>
  void finish(OnSweep on_sweep) {
    odometry_.finish();
    process_due(Stamp::latest(), on_sweep);
  }

  /// True if sweeps measure the motion; else they are only deskewed.
  bool uses_lidar() const { return lidar_motion_.has_value(); }
  /// Dead reckoning so far.
  const geometry::Trajectory& trajectory() const { return odometry_.trajectory(); }
  /// True if the motion up to the last sweep was measured by its registration.
  bool registered() const { return registered_; }

 private:
  bool is_due(const Sweep& sweep, Stamp now) const;
  void process(const Sweep& sweep);

  OdometryTracker odometry_;
  std::optional<LidarMotion> lidar_motion_;
  Duration max_wait_;
  motion::Deskewer deskewer_;
  Reference reference_;
  motion::DeskewedSweep deskewed_;
  std::deque<Sweep> waiting_;
  bool registered_ = false;
};

}  // namespace infuse::daemon

#pragma once

#include <deque>

#include "daemon/pipeline/lidar_motion.hpp"
#include "daemon/setup/drive_setup.hpp"
#include "fusion/mapping/keyframes.hpp"

namespace infuse::daemon {

/// Odometry of a recording from one lidar and the vehicle's sensors, as the daemon has it with
/// `use_lidar`: each sweep waits until the sensors cover its time, is deskewed by prediction,
/// registered, and deskewed by what odometry then knows.
class LidarReplay {
 public:
  LidarReplay(const SensorSetup& setup, size_t lidar);

  void add_sample(const VehicleSample& sample) { odometry_.add(sample); }
  void add_sweep(const Sweep& sweep);

  /// Calls `on_sweep(const Sweep&, const motion::DeskewedSweep&, const mapping::SweepMotion&)` for
  /// every sweep that is due at the drive time `now`; deskewed to its end.
  template <class OnSweep>
  void process_due(Stamp now, OnSweep on_sweep) {
    while (!waiting_.empty() && is_due(waiting_.front(), now)) {
      const mapping::SweepMotion motion = process(waiting_.front());
      on_sweep(waiting_.front(), deskewed_, motion);
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
  static Stamp end_of(const Sweep& sweep) { return sweep.stamp + sweep.span; }
  bool is_due(const Sweep& sweep, Stamp now) const;
  mapping::SweepMotion process(const Sweep& sweep);

  OdometryTracker odometry_;
  LidarMotion lidar_motion_;
  motion::Deskewer deskewer_;
  bool has_motion_sensor_;
  Duration max_wait_;
  motion::DeskewedSweep deskewed_;
  std::deque<Sweep> waiting_;
  Stamp last_ = Stamp::earliest();  // end of the sweep before
};

}  // namespace infuse::daemon

#pragma once

#include "daemon/playback/deskewed_sweeps.hpp"
#include "daemon/setup/sensor_setup.hpp"
#include "fusion/mapping/keyframes.hpp"

namespace infuse::daemon {

/// Deskewed sweeps of a recording with the motion between them, for a map. The lidar measures it,
/// beside the vehicle's sensors.
class LidarReplay {
 public:
  LidarReplay(const SensorSetup& setup, size_t lidar);

  void add_sample(const VehicleSample& sample) { sweeps_.add_sample(sample); }
  void add_sweep(const Sweep& sweep) { sweeps_.add_sweep(sweep); }

  /// Calls `on_sweep(const Sweep&, const motion::DeskewedSweep&, const mapping::SweepMotion&)` for
  /// every sweep that is due at the drive time `now`; deskewed to its end.
  template <class OnSweep>
  void process_due(Stamp now, OnSweep on_sweep) {
    sweeps_.process_due(now, with_motion(on_sweep));
  }

  /// Does the same for all remaining sweeps at the end of the recording.
  template <class OnSweep>
  void finish(OnSweep on_sweep) {
    sweeps_.finish(with_motion(on_sweep));
  }

 private:
  template <class OnSweep>
  auto with_motion(OnSweep& on_sweep) {
    return [this, &on_sweep](const Sweep& sweep, const motion::DeskewedSweep& deskewed) {
      on_sweep(sweep, deskewed, motion_until(deskewed.reference));
    };
  }
  mapping::SweepMotion motion_until(Stamp end);

  DeskewedSweeps sweeps_;
  bool has_motion_sensor_;
  Stamp last_ = Stamp::earliest();  // end of the sweep before
};

}  // namespace infuse::daemon

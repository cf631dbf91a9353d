#pragma once

#include "daemon/pipeline/odometry_tracker.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/motion/deskew.hpp"
#include "fusion/registration/lidar_odometry.hpp"

namespace infuse::daemon {

/// The motion that one lidar measures for odometry, sweep by sweep.
class LidarMotion {
 public:
  explicit LidarMotion(const Eigen::Isometry3d& T_vehicle_lidar);

  /// Registers a sweep to the local map and adds its motion to odometry, whose time is the sweep's
  /// end. `deskewed` is the sweep as of its end, deskewed by prediction, and is deskewed again by
  /// what was measured; `deskew()` deskews it by odometry. Returns true if the motion was measured.
  ///
  /// Where the motion is not as predicted, the sweep is registered once more, deskewed by what was
  /// measured: a sweep that is deskewed for too large a speed shows one that is too large by half
  /// as much. A map that was started before the motion was known is reset: deskewed sweeps do not
  /// fit it.
  template <class Deskew>
  bool measure(const Sweep& sweep, OdometryTracker& odometry, motion::Deskewer& deskewer,
               motion::DeskewedSweep& deskewed, Deskew deskew) {
    const bool predicted = deskewed.usable();
    Found found = align(sweep, odometry, deskewer, deskewed);
    if (found.measured) odometry.add(found.result.motion);
    if (found.measured || found.wrong) deskew();
    take(found, predicted, deskewed);
    return found.measured;
  }

 private:
  struct Found {
    registration::LidarOdometryResult result;
    bool first = false, wrong = false, measured = false;
  };
  Found align(const Sweep& sweep, const OdometryTracker& odometry, motion::Deskewer& deskewer,
              motion::DeskewedSweep& deskewed);
  void take(const Found& found, bool predicted, const motion::DeskewedSweep& deskewed);

  registration::LidarOdometry lidar_odometry_;
  geometry::Trajectory measured_motion_;       // of the sweep that is registered, at constant twist
  Stamp last_registered_ = Stamp::earliest();  // end of a sweep
  bool located_ = false;                       // that sweep has a pose in the local map
  bool map_deskewed_ = false;                  // sweeps of the local map are deskewed
};

}  // namespace infuse::daemon

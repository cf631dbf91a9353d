#pragma once

#include <optional>

#include "daemon/pipeline/odometry_tracker.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/features/air_returns.hpp"
#include "fusion/motion/deskew.hpp"
#include "fusion/registration/lidar_trajectory.hpp"

namespace infuse::daemon {

/// The motion that one lidar measures for odometry, sweep by sweep: from the end of a sweep to the
/// end of the next.
///
/// While wheels measure the speed, a sweep is deskewed by odometry, and where its motion is not as
/// predicted, registered once more, deskewed by what was measured: a sweep that is deskewed for too
/// large a speed shows one that is too large by half as much. A map that was started before the
/// motion was known is reset: deskewed sweeps do not fit it.
///
/// Without wheels the prediction is the lidar's own motion, and that error would come back with
/// every sweep: then the lidar follows the vehicle by itself, by poses at the middles of the
/// sweeps, where a wrong speed moves nothing.
class LidarMotion {
 public:
  explicit LidarMotion(const Eigen::Isometry3d& T_vehicle_lidar);

  /// Forgets the sweeps until now, while the motion is not measured.
  void restart();

  /// Measures the motion until the end of a sweep and adds it to odometry, whose time is that end.
  /// `deskewed` is the sweep as of its end, deskewed by prediction, and may be deskewed again by
  /// what was measured; `deskew()` deskews it by odometry. Returns true if the motion was measured.
  template <class Deskew>
  bool measure(const Sweep& sweep, OdometryTracker& odometry, motion::Deskewer& deskewer,
               motion::DeskewedSweep& deskewed, Deskew deskew) {
    if (!by_wheels(odometry.has_wheels(), deskewed.reference)) {
      return follow(sweep, odometry, deskewed.reference, deskew);
    }
    followed_.reset();
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
    bool wrong = false, measured = false;
  };
  template <class Deskew>
  bool follow(const Sweep& sweep, OdometryTracker& odometry, Stamp end, Deskew deskew) {
    const std::optional<motion::RelativePose> motion = follow(sweep, odometry.trajectory(), end);
    if (!motion) return false;
    odometry.add(*motion);
    deskew();
    return true;
  }
  std::optional<motion::RelativePose> follow(const Sweep& sweep,
                                             const geometry::Trajectory& predicted, Stamp end);
  bool by_wheels(bool has_wheels, Stamp now);
  Found align(const Sweep& sweep, const OdometryTracker& odometry, motion::Deskewer& deskewer,
              motion::DeskewedSweep& deskewed);
  void take(const Found& found, bool predicted, const motion::DeskewedSweep& deskewed);

  /// Returns of the present sweep but those of the air.
  geometry::PointsView points(const motion::DeskewedSweep& deskewed) {
    return {air_.without(deskewed.x), deskewed.y, deskewed.z};
  }

  features::AirReturns air_;
  registration::LidarOdometry lidar_odometry_;  // with wheels
  geometry::Trajectory measured_motion_;       // of the sweep that is registered, at constant twist
  Stamp last_registered_ = Stamp::earliest();  // end of a sweep
  bool map_deskewed_ = false;                  // sweeps of the local map are deskewed

  std::optional<bool> by_wheels_;                   // what is done
  Stamp other_since_ = Stamp::latest();             // that wheels came or went since
  registration::LidarTrajectory lidar_trajectory_;  // without wheels
  /// The last sweep's end there, with the pose if it was found.
  struct End {
    Stamp stamp, middle;  // of the sweep
    std::optional<Eigen::Isometry3d> T_map_vehicle;
  };
  std::optional<End> followed_;
};

}  // namespace infuse::daemon

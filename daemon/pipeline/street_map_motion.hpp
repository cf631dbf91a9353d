#pragma once

#include "drivers/measurement/stamp.hpp"
#include "fusion/geometry/trajectory.hpp"
#include "fusion/streetmap/planar_pose.hpp"
#include "fusion/streetmap/tracker.hpp"

namespace infuse::daemon {

/// The part of a pose that lies in the plane.
streetmap::PlanarPose planar(const Eigen::Isometry3d& T);

/// How the vehicle moves between the times of the tracker: by the trajectory of the odometry, and
/// where that has a gap, by what the odometry predicts without a source of speed or rotation.
class StreetMapMotion {
 public:
  /// Predicts `tracker` up to a time; one before the last begins anew. `predicted`: where the
  /// odometry has the vehicle now, measured or not.
  void predict(streetmap::Tracker& tracker, const geometry::Trajectory& trajectory,
               const geometry::PoseAt& predicted, Stamp to);

  /// The last time.
  Stamp now() const { return now_; }

 private:
  Stamp now_ = Stamp::earliest();
  geometry::PoseAt last_;  // frame `odom`, at that time
};

}  // namespace infuse::daemon

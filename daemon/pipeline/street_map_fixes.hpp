#pragma once

#include <optional>
#include <vector>

#include "drivers/gnss/local_frame.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "fusion/geometry/trajectory.hpp"
#include "fusion/streetmap/gnss_witness.hpp"
#include "fusion/streetmap/planar_pose.hpp"

namespace infuse::daemon {

/// Initial pose on the map, from several GNSS fixes.
struct InitialPoseFromFixes {
  streetmap::PlanarPose pose;
  double hdop = 1;  ///< median of the fixes
};

/// GNSS fixes of the last seconds in the map frame, moved by odometry to a common time.
class StreetMapFixes {
 public:
  explicit StreetMapFixes(const gnss::LocalFrame& frame);

  /// Keeps a valid fix; others are ignored.
  void add(const GnssFix& fix);

  /// Takes the next fix up to `now`, moved to `now` with its course, or else the heading (rad) of
  /// the vehicle there. Nothing if there is none; fixes that odometry does not connect with `now`
  /// are dropped.
  std::optional<streetmap::MapFix> take(Stamp now, double yaw,
                                        const geometry::Trajectory& trajectory);

  /// Returns the median of the last fixes at `now`, once there are enough of a stated dilution that
  /// is good enough, and of courses.
  std::optional<InitialPoseFromFixes> initial_pose(Stamp now,
                                                   const geometry::Trajectory& trajectory) const;

 private:
  struct Fix {
    Stamp stamp;
    Eigen::Vector2d position;   // m, map frame
    std::optional<double> yaw;  // rad, map frame
    double hdop;
  };

  gnss::LocalFrame frame_;
  std::vector<Fix> fixes_;  // oldest first
  size_t next_ = 0;         // the first that was not taken
};

}  // namespace infuse::daemon

#pragma once

#include <deque>
#include <vector>

#include "daemon/pipeline/odometry_stage.hpp"
#include "fusion/motion/compensation.hpp"

namespace infuse::daemon {

/// Makes the sweeps of one lidar of a recording straight, as the daemon does: each waits until
/// odometry covers its time.
class StraightSweeps {
 public:
  StraightSweeps(const Eigen::Isometry3d& T_vehicle_lidar, const OdometrySettings& settings)
      : odometry_(settings), max_wait_(settings.max_wait), compensator_(T_vehicle_lidar) {}

  void take(const VehicleSample& sample) { odometry_.take(sample); }
  void take(const Sweep& sweep) { waiting_.push_back(sweep); }

  /// Calls `use(const Sweep&, const StraightSweep&)` for every sweep that waits no longer at the
  /// drive time `now`; x, y and z are as of the sweep's end.
  template <class Use>
  void release(Stamp now, Use use) {
    while (!waiting_.empty() && due(waiting_.front(), now)) {
      const Sweep& sweep = waiting_.front();
      compensator_.compensate(sweep, odometry_.trajectory(), sweep.stamp + sweep.span, straight_);
      use(sweep, straight_);
      waiting_.pop_front();
    }
  }

  /// The recording has ended: the same for all.
  template <class Use>
  void finish(Use use) {
    odometry_.finish();
    release(Stamp::latest(), use);
  }

 private:
  bool due(const Sweep& sweep, Stamp now) const {
    const Stamp end = sweep.stamp + sweep.span;
    return now - end >= max_wait_ || *odometry_.trajectory().uncovered(sweep.stamp, end) == '\0';
  }

  OdometryStage odometry_;
  Duration max_wait_;
  motion::MotionCompensator compensator_;
  motion::StraightSweep straight_;
  std::deque<Sweep> waiting_;
};

}  // namespace infuse::daemon

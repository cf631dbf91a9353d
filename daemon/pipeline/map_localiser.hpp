#pragma once

#include <optional>
#include <vector>

#include "daemon/calibration/background_worker.hpp"
#include "daemon/health/map_health.hpp"
#include "daemon/pipeline/image_match.hpp"
#include "daemon/protocol/reports.hpp"
#include "fusion/features/air_returns.hpp"
#include "fusion/geometry/trajectory.hpp"
#include "fusion/places/localiser.hpp"

namespace infuse::daemon {

/// Localisation on a map of keyframes (`places::Localiser`) on a background thread. Sweeps wait for
/// it, bounded; what it found becomes visible after a fixed drive time, so a replay gives the same
/// poses at any rate, and is carried to the present by odometry.
class MapLocaliser {
 public:
  /// `blocking`: a replay, which waits for results; live they become visible later.
  MapLocaliser(places::PlaceMap map, const Eigen::Isometry3d& T_vehicle_lidar, bool blocking);

  /// Adds a deskewed sweep; its copy waits for the background thread. Returns the pose on the map
  /// as of the snapshot; stamp, speed and yaw rate are those of `odometry`.
  PoseReport process(const SweepSnapshot& snapshot, const geometry::Trajectory& trajectory,
                     const PoseReport& odometry);

  /// Returns the status for HEALTH.
  MapStatus status() const;

  /// Stops waiting for background work; from any thread.
  void shut_down() { worker_.shut_down(); }

 private:
  /// A copy of a deskewed sweep.
  struct WaitingSweep {
    FieldVector<float> x, y, z, reflectivity;
    mapping::SweepMotion motion;
  };
  /// Sweeps of one piece of background work; the memory is used again.
  struct Batch {
    std::vector<WaitingSweep> sweeps;
    size_t size = 0;
  };

  void add(const SweepSnapshot& snapshot, const geometry::Trajectory& trajectory);
  void start_work(Stamp now);
  void consume(const places::LocaliserPose& found);
  PoseReport carry(const geometry::Trajectory& trajectory, const PoseReport& odometry);

  features::AirReturns air_;
  places::Localiser localiser_;     // used by the background thread
  Batch waiting_, working_;         // the second is the background thread's while it works
  places::LocaliserPose result_;    // written by the background thread, read when it has ended
  const char* failure_ = "";        // why the map cannot be read, written and read likewise
  uint64_t result_verified_ = 0;    // likewise
  Stamp last_ = Stamp::earliest();  // of the sweep added last
  places::LocaliserPose pose_;      // visible
  const char* reason_ = "no sweep yet";
  MapStatus status_;
  BackgroundWorker worker_;  // last member: uses the others
};

}  // namespace infuse::daemon

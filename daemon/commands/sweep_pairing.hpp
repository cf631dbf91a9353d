#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/pipeline/odometry_tracker.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/motion/deskew.hpp"

namespace infuse::daemon {

/// The sweep nearest to an exposure.
struct PairedSweep {
  bool found = false;
  Duration gap{0};  ///< from the exposure to the middle of the sweep
  Sweep sweep;      ///< x, y, z and range as of the exposure, where `uncompensated` is empty
  std::string deskew_reason;  ///< why they are as they were measured
  /// The lidar's motion in its own frame at the exposure, rad/s and m/s, where odometry tells it.
  std::optional<geometry::Vector6> twist;
};

/// Finds each of some exposures the sweep of a recording that is nearest in time, and corrects it
/// for the vehicle's motion to the exposure's time. Keeps one sweep an exposure.
class SweepPairing {
 public:
  /// Without odometry nothing is corrected.
  SweepPairing(const Eigen::Isometry3d& T_vehicle_lidar, bool has_odometry);

  /// An exposure; in order of time, before anything is taken.
  void add_exposure(Stamp exposure);

  void add_sweep(const Sweep& sweep);
  void add_sample(const VehicleSample& sample);

  /// The recording has come to `now`: corrects what waits no longer.
  void advance(Stamp now);

  /// All exposures have their sweep.
  bool done() const { return next_ == exposures_.size(); }

  /// The recording has ended. One entry an exposure, in the order in which they were wanted.
  std::vector<PairedSweep> finish();

 private:
  void deskew(size_t exposure);

  std::optional<geometry::Vector6> twist_at(Stamp exposure) const;

  bool has_odometry_;
  Eigen::Isometry3d T_vehicle_lidar_;
  OdometryTracker odometry_{OdometrySettings{}};
  motion::Deskewer deskewer_;
  motion::DeskewedSweep deskewed_;
  std::vector<Stamp> exposures_;
  std::vector<PairedSweep> pairs_;
  size_t next_ = 0;  ///< the first exposure that is not settled
};

}  // namespace infuse::daemon

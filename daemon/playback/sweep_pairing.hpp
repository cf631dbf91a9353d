#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/pipeline/pairing.hpp"
#include "daemon/playback/deskewed_sweeps.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/motion/deskew.hpp"

namespace infuse::daemon {

/// The sweep nearest to an exposure.
struct PairedSweep {
  bool found = false;
  Duration gap{0};            ///< `pairing_gap`; zero within the sweep's span
  Sweep sweep;                ///< deskewed to the exposure if `deskew_reason` is empty
  std::string deskew_reason;  ///< why the sweep is not deskewed
  Duration uncompensated{0};  ///< maximum time from the exposure to a return that is not deskewed
  /// Twist of the lidar in its own frame at the exposure, rad/s and m/s, if odometry covers it.
  std::optional<geometry::Vector6> twist;
};

/// Finds the sweep of a recording that is nearest in time to each exposure, and deskews it to the
/// exposure's time. Keeps one sweep per exposure.
class SweepPairing {
 public:
  /// The settings are those of `plan_odometry`. Sweeps farther than `max_gap` from an exposure are
  /// not paired with it. Without odometry only sweeps that their source has deskewed to the
  /// exposure count as deskewed.
  SweepPairing(const OdometrySettings& settings, const Eigen::Isometry3d& T_vehicle_lidar,
               bool has_odometry, Duration max_gap = kMaxPairingGap);

  /// Adds an exposure; in order of time, before any sweep or sample.
  void add_exposure(Stamp exposure);

  void add_sweep(const Sweep& sweep);
  void add_sample(const VehicleSample& sample);

  /// Deskews the sweeps that are due at the drive time `now`.
  void advance(Stamp now);

  /// True if all exposures are settled.
  bool done() const { return next_ == exposures_.size(); }

  /// Number of exposures that are settled; these are the first ones.
  size_t settled() const { return next_; }

  /// Takes the sweep of a settled exposure, so that it does not occupy memory to the end.
  PairedSweep take(size_t exposure) { return std::exchange(pairs_[exposure], {}); }

  /// Ends the recording. Returns one entry per exposure, in the order in which they were added;
  /// those that were taken are not found.
  std::vector<PairedSweep> finish();

 private:
  void deskew(size_t exposure);

  std::optional<geometry::Vector6> twist_at(Stamp exposure) const;

  bool has_odometry_;
  Duration max_gap_;
  Eigen::Isometry3d T_vehicle_lidar_;
  DeskewedSweeps odometry_;
  motion::Deskewer deskewer_;
  motion::DeskewedSweep deskewed_;
  std::vector<Stamp> exposures_;
  std::vector<PairedSweep> pairs_;
  size_t next_ = 0;  ///< first exposure that is not settled
};

}  // namespace infuse::daemon

#pragma once

#include <optional>
#include <random>

#include "daemon/pipeline/odometry_tracker.hpp"
#include "tests/study/months/fault.hpp"

namespace infuse::study {

/// A vehicle on a winding road: what its wheels, its yaw-rate sensor and its GNSS receiver measure
/// goes through the product's odometry.
///
/// Faults: vehicle slip S (wheels fast by that share), gnss fast V (m/s), gnss turned RAD (course).
class SimulatedVehicle {
 public:
  explicit SimulatedVehicle(uint64_t seed) : random_(seed) {}

  /// Begins a run of the daemon.
  void restart(const daemon::OdometrySettings& settings) { odometry_.emplace(settings); }

  /// Drives the second before `now`; `bus`, `gnss`: it delivers.
  void drive(Stamp now, bool bus, bool gnss, const FaultSchedule& faults);

  daemon::OdometryStatus status(Stamp now) const { return odometry_->status(now); }

 private:
  double noise(double sigma) { return std::normal_distribution<double>(0, sigma)(random_); }

  std::mt19937_64 random_;
  std::optional<daemon::OdometryTracker> odometry_;
  double seconds_ = 0, heading_ = 0, east_ = 0, north_ = 0;
};

}  // namespace infuse::study

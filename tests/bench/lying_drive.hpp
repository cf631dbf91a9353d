#pragma once

#include <array>
#include <vector>

#include "fusion/geometry/trajectory.hpp"
#include "tests/fusion/motion/true_drive.hpp"

namespace infuse::streetmap::bench {

/// What the wheels do from some time on.
struct WheelFault {
  const char* name = "";
  double seconds = 0;
  /// Measured over true speed: front left, front right, rear left, rear right.
  std::array<double, 4> factor{1, 1, 1, 1};
  bool carried = false;  ///< the vehicle stops, is carried on with wheels at rest, and drives on
};

/// A route that is driven with a wheel fault: when the vehicle is where, and how it moves then.
class LyingDrive {
 public:
  /// `route`: true poses; `first`: s of the route at which the drive begins; the fault begins at
  /// `begin` (s of the drive). Steps are `kStep` long.
  LyingDrive(const geometry::Trajectory& route, double first, const WheelFault& fault, double begin,
             double seconds);

  /// s of the route at a time of the drive.
  double route_seconds(double t) const;

  /// True poses relative to the first, and noiseless sensors.
  const motion::TrueDrive& drive() const { return drive_; }

  /// The share of the true speed that a wheel measures.
  double factor(size_t wheel, double t) const;

  /// True pose on the route.
  Eigen::Isometry3d pose(double t) const;

  /// s of the drive.
  double fault_end() const { return begin_ + fault_.seconds; }

 private:
  double pace(double t) const;
  std::vector<double> route_times(double first, double seconds) const;
  std::vector<geometry::Vector6> twists() const;
  geometry::Vector6 twist(double t) const;

  static constexpr double kStep = 0.01;  // s
  const geometry::Trajectory& route_;
  WheelFault fault_;
  double begin_;
  std::vector<double> route_seconds_;
  std::vector<geometry::Vector6> twists_;
  motion::TrueDrive drive_;
};

}  // namespace infuse::streetmap::bench

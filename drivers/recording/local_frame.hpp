#pragma once

#include <Eigen/Core>

namespace infuse::recording {

/// The east-north-up frame that touches the WGS 84 ellipsoid's parallel surface at an origin. Exact
/// (through earth-centred coordinates), so no projection distorts it: at distance d the ground lies
/// d²/12 740 km below the plane.
class LocalFrame {
 public:
  /// Radians, radians, metres above the ellipsoid.
  LocalFrame(double latitude, double longitude, double altitude = 0);

  /// Metres east, north, up of the origin.
  Eigen::Vector3d to_local(double latitude, double longitude, double altitude = 0) const;

  /// Latitude (rad), longitude (rad), altitude (m); the inverse of `to_local` within 1 µm up to
  /// 1000 km away.
  Eigen::Vector3d to_geodetic(const Eigen::Vector3d& local) const;

 private:
  Eigen::Vector3d origin_ecef_;  ///< earth-centred, m
  Eigen::Matrix3d R_local_ecef_;
};

}  // namespace infuse::recording

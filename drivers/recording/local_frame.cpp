#include "drivers/recording/local_frame.hpp"

#include <cmath>

namespace infuse::recording {
namespace {

// WGS 84.
constexpr double kSemiMajor = 6378137.0;
constexpr double kFlattening = 1 / 298.257223563;
constexpr double kEccentricity2 = kFlattening * (2 - kFlattening);

Eigen::Vector3d to_earth(double latitude, double longitude, double altitude) {
  const double sin_lat = std::sin(latitude), cos_lat = std::cos(latitude);
  const double normal = kSemiMajor / std::sqrt(1 - kEccentricity2 * sin_lat * sin_lat);
  return {(normal + altitude) * cos_lat * std::cos(longitude),
          (normal + altitude) * cos_lat * std::sin(longitude),
          (normal * (1 - kEccentricity2) + altitude) * sin_lat};
}

}  // namespace

LocalFrame::LocalFrame(double latitude, double longitude, double altitude)
    : origin_(to_earth(latitude, longitude, altitude)) {
  const double sin_lat = std::sin(latitude), cos_lat = std::cos(latitude);
  const double sin_lon = std::sin(longitude), cos_lon = std::cos(longitude);
  R_local_earth_ << -sin_lon, cos_lon, 0,               //
      -sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat,  //
      cos_lat * cos_lon, cos_lat * sin_lon, sin_lat;
}

Eigen::Vector3d LocalFrame::to_local(double latitude, double longitude, double altitude) const {
  return R_local_earth_ * (to_earth(latitude, longitude, altitude) - origin_);
}

Eigen::Vector3d LocalFrame::to_geodetic(const Eigen::Vector3d& local) const {
  const Eigen::Vector3d earth = R_local_earth_.transpose() * local + origin_;
  const double axis_distance = std::hypot(earth.x(), earth.y());
  // Fixed-point iteration; each step gains more than two digits near the surface.
  double latitude = std::atan2(earth.z(), axis_distance * (1 - kEccentricity2));
  double altitude = 0;
  for (int step = 0; step < 10; ++step) {
    const double sin_lat = std::sin(latitude), cos_lat = std::cos(latitude);
    const double normal = kSemiMajor / std::sqrt(1 - kEccentricity2 * sin_lat * sin_lat);
    altitude = axis_distance * cos_lat + earth.z() * sin_lat -
               normal * (1 - kEccentricity2 * sin_lat * sin_lat);
    latitude = std::atan2(earth.z() + kEccentricity2 * normal * sin_lat, axis_distance);
  }
  return {latitude, std::atan2(earth.y(), earth.x()), altitude};
}

}  // namespace infuse::recording

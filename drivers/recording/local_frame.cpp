#include "drivers/recording/local_frame.hpp"

#include <cmath>

namespace infuse::recording {
namespace {

// WGS 84.
constexpr double kSemiMajorAxis = 6378137.0;
constexpr double kFlattening = 1 / 298.257223563;
constexpr double kEccentricitySquared = kFlattening * (2 - kFlattening);

Eigen::Vector3d to_ecef(double latitude, double longitude, double altitude) {
  const double sin_lat = std::sin(latitude), cos_lat = std::cos(latitude);
  const double prime_vertical_radius =
      kSemiMajorAxis / std::sqrt(1 - kEccentricitySquared * sin_lat * sin_lat);
  return {(prime_vertical_radius + altitude) * cos_lat * std::cos(longitude),
          (prime_vertical_radius + altitude) * cos_lat * std::sin(longitude),
          (prime_vertical_radius * (1 - kEccentricitySquared) + altitude) * sin_lat};
}

}  // namespace

LocalFrame::LocalFrame(double latitude, double longitude, double altitude)
    : origin_ecef_(to_ecef(latitude, longitude, altitude)) {
  const double sin_lat = std::sin(latitude), cos_lat = std::cos(latitude);
  const double sin_lon = std::sin(longitude), cos_lon = std::cos(longitude);
  R_local_ecef_ << -sin_lon, cos_lon, 0,                //
      -sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat,  //
      cos_lat * cos_lon, cos_lat * sin_lon, sin_lat;
}

Eigen::Vector3d LocalFrame::to_local(double latitude, double longitude, double altitude) const {
  return R_local_ecef_ * (to_ecef(latitude, longitude, altitude) - origin_ecef_);
}

Eigen::Vector3d LocalFrame::to_geodetic(const Eigen::Vector3d& local) const {
  const Eigen::Vector3d ecef = R_local_ecef_.transpose() * local + origin_ecef_;
  const double axis_distance = std::hypot(ecef.x(), ecef.y());
  // Fixed-point iteration; each step gains more than two digits near the surface.
  double latitude = std::atan2(ecef.z(), axis_distance * (1 - kEccentricitySquared));
  double altitude = 0;
  for (int step = 0; step < 10; ++step) {
    const double sin_lat = std::sin(latitude), cos_lat = std::cos(latitude);
    const double prime_vertical_radius =
        kSemiMajorAxis / std::sqrt(1 - kEccentricitySquared * sin_lat * sin_lat);
    altitude = axis_distance * cos_lat + ecef.z() * sin_lat -
               prime_vertical_radius * (1 - kEccentricitySquared * sin_lat * sin_lat);
    latitude = std::atan2(ecef.z() + kEccentricitySquared * prime_vertical_radius * sin_lat,
                          axis_distance);
  }
  return {latitude, std::atan2(ecef.y(), ecef.x()), altitude};
}

}  // namespace infuse::recording

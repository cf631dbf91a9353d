#include "drivers/gnss/local_frame.hpp"

#include <cmath>

#include "drivers/measurement/angles.hpp"

namespace infuse::gnss {
namespace {

// 0.24 mm, less than any receiver resolves. The last bits of what GeographicLib computes differ
// between processors, by nanometres; whoever goes on with them draws other particles.
constexpr double kStepsPerMetre = 4096;

}  // namespace

LocalFrame make_local_frame(double latitude, double longitude, double altitude) {
  return {latitude / kDegree, longitude / kDegree, altitude};
}

Eigen::Vector3d to_local(const LocalFrame& frame, double latitude, double longitude,
                         double altitude) {
  Eigen::Vector3d local;
  frame.Forward(latitude / kDegree, longitude / kDegree, altitude, local.x(), local.y(), local.z());
  for (double& part : local) part = std::round(part * kStepsPerMetre) / kStepsPerMetre;
  return local;
}

Eigen::Vector3d to_geodetic(const LocalFrame& frame, const Eigen::Vector3d& local) {
  double latitude = 0, longitude = 0, altitude = 0;
  frame.Reverse(local.x(), local.y(), local.z(), latitude, longitude, altitude);
  return {latitude * kDegree, longitude * kDegree, altitude};
}

}  // namespace infuse::gnss

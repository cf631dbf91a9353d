#include "drivers/gnss/local_frame.hpp"

#include "drivers/measurement/angles.hpp"

namespace infuse::gnss {

LocalFrame make_local_frame(double latitude, double longitude, double altitude) {
  return {latitude / kDegree, longitude / kDegree, altitude};
}

Eigen::Vector3d to_local(const LocalFrame& frame, double latitude, double longitude,
                         double altitude) {
  Eigen::Vector3d local;
  frame.Forward(latitude / kDegree, longitude / kDegree, altitude, local.x(), local.y(), local.z());
  return local;
}

Eigen::Vector3d to_geodetic(const LocalFrame& frame, const Eigen::Vector3d& local) {
  double latitude = 0, longitude = 0, altitude = 0;
  frame.Reverse(local.x(), local.y(), local.z(), latitude, longitude, altitude);
  return {latitude * kDegree, longitude * kDegree, altitude};
}

}  // namespace infuse::gnss

#include "fusion/registration/pose_system.hpp"

#include <algorithm>
#include <cmath>

#include "fusion/registration/pairs.hpp"

namespace infuse::registration {

void Pairs::resize(size_t pairs) {
  size = pairs;
  for (Field* field :
       {&px, &py, &pz, &sx, &sy, &sz, &qx, &qy, &qz, &tx, &ty, &tz, &weight, &tilt}) {
    reserve_with_headroom(*field, padded());
    field->resize(padded());
    std::fill(field->begin() + static_cast<ptrdiff_t>(pairs), field->end(), 0.0F);
  }
  for (Field* field : {&sx, &sy, &sz, &tilt}) std::fill(field->begin(), field->end(), 0.0F);
}

PoseSystem pose_system(const std::array<double, kPoseSums>& sums, double isotropic) {
  PoseSystem system;
  size_t e = 0;
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) system.planes(r, c) = system.planes(c, r) = sums[e++];
  }
  for (int r = 0; r < 6; ++r) system.gradient[r] = sums[e++];
  system.cost = sums[e++];
  system.weight = sums[e++];
  if (!(system.weight > 0)) return system;
  const Eigen::Vector3d first(sums[e], sums[e + 1], sums[e + 2]);
  Eigen::Matrix3d second;
  second << sums[e + 3], sums[e + 4], sums[e + 5], sums[e + 4], sums[e + 6], sums[e + 7],
      sums[e + 5], sums[e + 7], sums[e + 8];
  system.mean = first / system.weight;
  system.radius =
      std::sqrt(std::max(second.trace() / system.weight - system.mean.squaredNorm(), 0.0));
  system.arms = second.trace() * Eigen::Matrix3d::Identity() - second;
  system.isotropic.topLeftCorner<3, 3>() = isotropic * system.arms;
  system.isotropic.topRightCorner<3, 3>() = isotropic * geometry::skew(first);
  system.isotropic.bottomLeftCorner<3, 3>() = -isotropic * geometry::skew(first);
  system.isotropic.bottomRightCorner<3, 3>() =
      isotropic * system.weight * Eigen::Matrix3d::Identity();
  return system;
}

}  // namespace infuse::registration

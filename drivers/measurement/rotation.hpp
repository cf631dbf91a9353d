#pragma once

#include <Eigen/Geometry>

namespace infuse {

/// The rotation near a matrix whose columns are orthonormal but for rounding, which would grow in
/// products of many.
inline Eigen::Matrix3d orthonormal(const Eigen::Matrix3d& R) {
  return Eigen::Quaterniond(R).normalized().toRotationMatrix();
}

}  // namespace infuse

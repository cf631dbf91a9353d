#pragma once

#include <Eigen/Core>
#include <span>

#include "drivers/measurement/rig.hpp"

namespace infuse::target {

/// Intrinsics as numbers: fx, fy, cx, cy (px), then the distortion in the order of
/// `CameraIntrinsics`; the last one is 0 for a fisheye.
using IntrinsicsVector = Eigen::Matrix<double, 9, 1>;

/// Number of intrinsics of a model: the first ones of an `IntrinsicsVector`.
int intrinsics_count(CameraIntrinsics::Model model);

/// Their names: "fx", …, "k1", …
std::span<const char* const> intrinsics_names(CameraIntrinsics::Model model);

/// The numbers of a camera's intrinsics.
IntrinsicsVector to_vector(const CameraIntrinsics& intrinsics);

/// The camera with other numbers.
CameraIntrinsics with_vector(const CameraIntrinsics& camera, const IntrinsicsVector& numbers);

/// Derivative of the pixel of a point (m, camera frame) by the intrinsics; the point must be one
/// that `geometry::CameraModel::project` projects.
Eigen::Matrix<double, 2, 9> derivative_by_intrinsics(const CameraIntrinsics& camera,
                                                     const Eigen::Vector3d& point);

}  // namespace infuse::target

#include "fusion/target/intrinsics_vector.hpp"

#include <array>
#include <cmath>

namespace infuse::target {
namespace {

constexpr std::array kPinholeNames = {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
constexpr std::array kFisheyeNames = {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4"};

/// Derivative of the distorted image coordinates by the distortion, and these coordinates.
struct Distorted {
  Eigen::Vector2d at;
  Eigen::Matrix<double, 2, 5> by_distortion = Eigen::Matrix<double, 2, 5>::Zero();
};

Distorted distort_pinhole(const CameraIntrinsics& camera, const Eigen::Vector3d& point) {
  const double a = point.x() / point.z(), b = point.y() / point.z();
  const double s = a * a + b * b;
  const Eigen::Vector2d direction(a, b);
  Distorted out;
  out.by_distortion.col(0) = s * direction;
  out.by_distortion.col(1) = s * s * direction;
  out.by_distortion.col(2) << 2 * a * b, s + 2 * b * b;
  out.by_distortion.col(3) << s + 2 * a * a, 2 * a * b;
  out.by_distortion.col(4) = s * s * s * direction;
  out.at = direction + out.by_distortion *
                           Eigen::Map<const Eigen::Matrix<double, 5, 1>>(camera.distortion.data());
  return out;
}

Distorted distort_fisheye(const CameraIntrinsics& camera, const Eigen::Vector3d& point) {
  const double radius = std::hypot(point.x(), point.y());
  const double angle = std::atan2(radius, point.z());
  Distorted out;
  if (!(radius > 0)) {
    out.at.setZero();
    return out;
  }
  const Eigen::Vector2d direction = angle / radius * point.head<2>();
  double power = 1;
  for (int k = 0; k < 4; ++k) {
    power *= angle * angle;
    out.by_distortion.col(k) = power * direction;
  }
  out.at = direction + out.by_distortion *
                           Eigen::Map<const Eigen::Matrix<double, 5, 1>>(camera.distortion.data());
  return out;
}

}  // namespace

int intrinsics_count(CameraIntrinsics::Model model) {
  return static_cast<int>(intrinsics_names(model).size());
}

std::span<const char* const> intrinsics_names(CameraIntrinsics::Model model) {
  if (model == CameraIntrinsics::Model::kPinhole) return kPinholeNames;
  return kFisheyeNames;
}

IntrinsicsVector to_vector(const CameraIntrinsics& intrinsics) {
  IntrinsicsVector numbers;
  numbers << intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy,
      Eigen::Map<const Eigen::Matrix<double, 5, 1>>(intrinsics.distortion.data());
  return numbers;
}

CameraIntrinsics with_vector(const CameraIntrinsics& camera, const IntrinsicsVector& numbers) {
  CameraIntrinsics out = camera;
  out.fx = numbers(0);
  out.fy = numbers(1);
  out.cx = numbers(2);
  out.cy = numbers(3);
  Eigen::Map<Eigen::Matrix<double, 5, 1>>(out.distortion.data()) = numbers.tail<5>();
  return out;
}

Eigen::Matrix<double, 2, 9> derivative_by_intrinsics(const CameraIntrinsics& camera,
                                                     const Eigen::Vector3d& point) {
  const Distorted distorted = camera.model == CameraIntrinsics::Model::kPinhole
                                  ? distort_pinhole(camera, point)
                                  : distort_fisheye(camera, point);
  Eigen::Matrix<double, 2, 9> J;
  J.leftCols<4>() << distorted.at.x(), 0, 1, 0, 0, distorted.at.y(), 0, 1;
  J.row(0).tail<5>() = camera.fx * distorted.by_distortion.row(0);
  J.row(1).tail<5>() = camera.fy * distorted.by_distortion.row(1);
  return J;
}

}  // namespace infuse::target

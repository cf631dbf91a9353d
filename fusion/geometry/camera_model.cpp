#include "fusion/geometry/camera_model.hpp"

#include <cmath>
#include <numbers>

#include "fusion/geometry/plane_length.hpp"
#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::geometry {
namespace {

using Distortion = std::array<double, 5>;

/// Radial distortion factor 1 + k1 s + k2 s² + k3 s³ (+ k4 s⁴), with s = r² (pinhole) or s = θ²
/// (fisheye).
double radial_factor(const CameraIntrinsics& camera, double s) {
  const Distortion& k = camera.distortion;
  if (camera.model == CameraIntrinsics::Model::kPinhole) {
    return 1 + s * (k[0] + s * (k[1] + s * k[4]));
  }
  return 1 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3])));
}

/// Derivative d(x · radial_factor(x²)) / dx at s = x².
double radial_derivative(const CameraIntrinsics& camera, double s) {
  const Distortion& k = camera.distortion;
  if (camera.model == CameraIntrinsics::Model::kPinhole) {
    return 1 + s * (3 * k[0] + s * (5 * k[1] + s * 7 * k[4]));
  }
  return 1 + s * (3 * k[0] + s * (5 * k[1] + s * (7 * k[2] + s * 9 * k[3])));
}

/// Solves x · radial_factor(x²) = value for x in 0 … max_radius by bisection; the left side
/// increases there.
std::optional<double> undistort_radius(const CameraIntrinsics& camera, double value,
                                       double max_radius) {
  if (value > max_radius * radial_factor(camera, max_radius * max_radius)) return std::nullopt;
  double low = 0, high = max_radius;
  for (int i = 0; i < 80 && high - low > 1e-16 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (middle * radial_factor(camera, middle * middle) < value ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Distorted image coordinates of the direction (a, b, 1) and their derivative with respect to (a,
/// b).
Eigen::Vector2d distort(const CameraIntrinsics& camera, double a, double b,
                        Eigen::Matrix2d* derivative) {
  const double p1 = camera.distortion[2], p2 = camera.distortion[3];
  const double s = a * a + b * b;
  const double g = radial_factor(camera, s);
  if (derivative != nullptr) {
    const Distortion& k = camera.distortion;
    const double dg = k[0] + s * (2 * k[1] + s * 3 * k[4]);  // with respect to s
    const double mixed = 2 * a * b * dg + 2 * p1 * a + 2 * p2 * b;
    *derivative << g + 2 * a * a * dg + 2 * p1 * b + 6 * p2 * a, mixed, mixed,
        g + 2 * b * b * dg + 6 * p1 * b + 2 * p2 * a;
  }
  return {a * g + 2 * p1 * a * b + p2 * (s + 2 * a * a),
          b * g + p1 * (s + 2 * b * b) + 2 * p2 * a * b};
}

}  // namespace

CameraModel::CameraModel(const CameraIntrinsics& intrinsics) : intrinsics_(intrinsics) {
  const bool pinhole = intrinsics.model == CameraIntrinsics::Model::kPinhole;
  const double max_angle = pinhole ? 89.5 / 180 * std::numbers::pi : std::numbers::pi;
  constexpr int kSteps = 4000;  // bounds time: the limit is known to 0.05°
  double last = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double angle = max_angle * i / kSteps;
    const double x = pinhole ? std::tan(angle) : angle;
    if (!(radial_derivative(intrinsics_, x * x) > 0)) break;
    last = x;
  }
  limit_ = pinhole ? last * last : last;
}

std::optional<Eigen::Vector2d> CameraModel::project(const Eigen::Vector3d& point) const {
  const CameraIntrinsics& c = intrinsics_;
  Eigen::Vector2d distorted;
  if (c.model == CameraIntrinsics::Model::kPinhole) {
    if (!(point.z() > 0)) return std::nullopt;
    const double a = point.x() / point.z(), b = point.y() / point.z();
    if (!(a * a + b * b <= limit_)) return std::nullopt;
    distorted = distort(c, a, b, nullptr);
  } else {
    const double radius = plane_length(point.x(), point.y());
    const double angle = std::atan2(radius, point.z());
    if (!(angle <= limit_) || !(radius + std::abs(point.z()) > 0)) return std::nullopt;
    const double g = radial_factor(c, angle * angle);
    // On the axis, angle / radius is 1 / z.
    const double per_metre = radius > 1e-9 * std::abs(point.z()) ? angle / radius : 1 / point.z();
    distorted = g * per_metre * point.head<2>();
  }
  return Eigen::Vector2d(c.fx * distorted.x() + c.cx, c.fy * distorted.y() + c.cy);
}

std::optional<ProjectionDerivatives> CameraModel::project_with_derivatives(
    const Eigen::Vector3d& point) const {
  const auto pixel = project(point);
  if (!pixel) return std::nullopt;
  const CameraIntrinsics& c = intrinsics_;
  Eigen::Matrix<double, 2, 3> J;
  if (c.model == CameraIntrinsics::Model::kPinhole) {
    const double w = 1 / point.z(), a = point.x() * w, b = point.y() * w;
    Eigen::Matrix2d by_direction;
    distort(c, a, b, &by_direction);
    Eigen::Matrix<double, 2, 3> direction;
    direction << w, 0, -a * w, 0, w, -b * w;
    J = by_direction * direction;
  } else {
    const double radius = plane_length(point.x(), point.y());
    const double squared = point.squaredNorm();
    if (radius <= 1e-9 * std::abs(point.z())) {
      J << 1 / point.z(), 0, 0, 0, 1 / point.z(), 0;
    } else {
      const double angle = std::atan2(radius, point.z());
      const double distorted = angle * radial_factor(c, angle * angle);
      const double by_angle = radial_derivative(c, angle * angle);
      const Eigen::Vector2d unit = point.head<2>() / radius;
      // d(angle)/d(radius) = z / |p|², d(angle)/dz = −radius / |p|².
      J.leftCols<2>() =
          by_angle * point.z() / squared * unit * unit.transpose() +
          distorted / radius * (Eigen::Matrix2d::Identity() - unit * unit.transpose());
      J.col(2) = -by_angle * radius / squared * unit;
    }
  }
  J.row(0) *= c.fx;
  J.row(1) *= c.fy;
  ProjectionDerivatives result;
  result.pixel = *pixel;
  result.by_point = J;
  result.by_pose.leftCols<3>() = -J * skew(point);
  result.by_pose.rightCols<3>() = J;
  return result;
}

std::optional<Eigen::Vector3d> CameraModel::unproject(const Eigen::Vector2d& pixel) const {
  if (!pixel.allFinite()) return std::nullopt;
  const CameraIntrinsics& c = intrinsics_;
  const Eigen::Vector2d distorted((pixel.x() - c.cx) / c.fx, (pixel.y() - c.cy) / c.fy);
  return c.model == CameraIntrinsics::Model::kPinhole ? unproject_pinhole(distorted)
                                                      : unproject_fisheye(distorted);
}

std::optional<Eigen::Vector3d> CameraModel::unproject_pinhole(
    const Eigen::Vector2d& distorted) const {
  const double max_radius = std::sqrt(limit_);
  const double radius = distorted.norm();
  // Initial value: the solution without tangential distortion; then Newton's method.
  const auto initial_radius = undistort_radius(
      intrinsics_, std::min(radius, max_radius * radial_factor(intrinsics_, limit_)), max_radius);
  if (!initial_radius) return std::nullopt;
  Eigen::Vector2d at =
      radius > 0 ? Eigen::Vector2d(distorted * (*initial_radius / radius)) : distorted;
  const double tolerance = 1e-9 / std::max(intrinsics_.fx, intrinsics_.fy);
  for (int i = 0; i < 20; ++i) {
    Eigen::Matrix2d derivative;
    const Eigen::Vector2d residual = distort(intrinsics_, at.x(), at.y(), &derivative) - distorted;
    if (!residual.allFinite()) return std::nullopt;
    if (residual.norm() <= tolerance * (1 + radius)) {
      if (at.squaredNorm() > limit_ * (1 + 1e-9)) return std::nullopt;
      return Eigen::Vector3d(at.x(), at.y(), 1).normalized();
    }
    at -= derivative.inverse() * residual;
  }
  return std::nullopt;
}

std::optional<Eigen::Vector3d> CameraModel::unproject_fisheye(
    const Eigen::Vector2d& distorted) const {
  const double radius = distorted.norm();
  const auto angle = undistort_radius(intrinsics_, radius, limit_);
  if (!angle) return std::nullopt;
  if (radius == 0) return Eigen::Vector3d(0, 0, 1);
  const double sine = std::sin(*angle);
  return Eigen::Vector3d(distorted.x() / radius * sine, distorted.y() / radius * sine,
                         std::cos(*angle));
}

bool CameraModel::in_image(const Eigen::Vector2d& pixel) const {
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < intrinsics_.width - 0.5 &&
         pixel.y() < intrinsics_.height - 0.5;
}

}  // namespace infuse::geometry

#include "fusion/geometry/rigid_motion.hpp"

#include <cmath>

namespace infuse::geometry {
namespace {

/// Functions of the angle in the closed forms; series near zero, where the closed forms cancel.
struct Coefficients {
  double a;  ///< sin θ / θ
  double b;  ///< (1 − cos θ) / θ²
  double c;  ///< (θ − sin θ) / θ³
  double d;  ///< (θ² + 2 cos θ − 2) / 2θ⁴
  double e;  ///< (2θ − 3 sin θ + θ cos θ) / 2θ⁵

  explicit Coefficients(double squared) {
    // What the series leave out is below rounding in double precision.
    constexpr double kMaxSeriesAngleSquared = 1e-2;
    const double s = squared;
    if (s < kMaxSeriesAngleSquared) {
      a = 1 - s / 6 * (1 - s / 20 * (1 - s / 42 * (1 - s / 72)));
      b = 0.5 * (1 - s / 12 * (1 - s / 30 * (1 - s / 56 * (1 - s / 90))));
      c = 1.0 / 6 * (1 - s / 20 * (1 - s / 42 * (1 - s / 72 * (1 - s / 110))));
      d = 1.0 / 24 * (1 - s / 30 * (1 - s / 56 * (1 - s / 90)));
      e = 1.0 / 120 - s / 2520 + s * s / 120960 - s * s * s / 9979200;
      return;
    }
    const double angle = std::sqrt(s);
    const double sine = std::sin(angle), cosine = std::cos(angle);
    a = sine / angle;
    b = (1 - cosine) / s;
    c = (angle - sine) / (s * angle);
    d = (s + 2 * cosine - 2) / (2 * s * s);
    e = (2 * angle - 3 * sine + angle * cosine) / (2 * s * s * angle);
  }
};

/// Lower left block of the left Jacobian, Barfoot (7.86b).
Eigen::Matrix3d coupling(const Eigen::Vector3d& w, const Eigen::Vector3d& v) {
  const Coefficients k(w.squaredNorm());
  const Eigen::Matrix3d W = skew(w), P = skew(v);
  const Eigen::Matrix3d WP = W * P, PW = P * W, WPW = W * PW;
  return 0.5 * P + k.c * (WP + PW + WPW) + k.d * (W * WP + PW * W - 3 * WPW) +
         k.e * (WPW * W + W * WPW);
}

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

Eigen::Matrix3d rotation_exp(const Eigen::Vector3d& w) {
  const Coefficients k(w.squaredNorm());
  const Eigen::Matrix3d W = skew(w);
  return Eigen::Matrix3d::Identity() + k.a * W + k.b * (W * W);
}

Eigen::Vector3d rotation_log(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();                           // sine of half the angle
  if (sine < 1e-4) return 2 * q.vec() * (1 + sine * sine / 6);  // asin(x) / x near 0
  return 2 * std::atan2(sine, q.w()) / sine * q.vec();
}

Eigen::Matrix3d rotation_left_jacobian(const Eigen::Vector3d& w) {
  const Coefficients k(w.squaredNorm());
  const Eigen::Matrix3d W = skew(w);
  return Eigen::Matrix3d::Identity() + k.b * W + k.c * (W * W);
}

Eigen::Matrix3d rotation_left_jacobian_inverse(const Eigen::Vector3d& w) {
  const double s = w.squaredNorm();
  const Coefficients k(s);
  // (1 − a / 2b) / θ²
  const double f =
      s < 1e-2 ? 1.0 / 12 * (1 + s / 60 * (1 + s / 42 * (1 + s / 40))) : (1 - k.a / (2 * k.b)) / s;
  const Eigen::Matrix3d W = skew(w);
  return Eigen::Matrix3d::Identity() - 0.5 * W + f * (W * W);
}

Eigen::Isometry3d exp(const Vector6& twist) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = rotation_exp(twist.head<3>());
  T.translation() = rotation_left_jacobian(twist.head<3>()) * twist.tail<3>();
  return T;
}

Vector6 log(const Eigen::Isometry3d& T) {
  Vector6 twist;
  twist.head<3>() = rotation_log(T.linear());
  twist.tail<3>() = rotation_left_jacobian_inverse(twist.head<3>()) * T.translation();
  return twist;
}

Matrix6 adjoint(const Eigen::Isometry3d& T) {
  Matrix6 A = Matrix6::Zero();
  A.topLeftCorner<3, 3>() = T.linear();
  A.bottomRightCorner<3, 3>() = T.linear();
  A.bottomLeftCorner<3, 3>() = skew(T.translation()) * T.linear();
  return A;
}

Matrix6 left_jacobian(const Vector6& twist) {
  Matrix6 J = Matrix6::Zero();
  J.topLeftCorner<3, 3>() = rotation_left_jacobian(twist.head<3>());
  J.bottomRightCorner<3, 3>() = J.topLeftCorner<3, 3>();
  J.bottomLeftCorner<3, 3>() = coupling(twist.head<3>(), twist.tail<3>());
  return J;
}

Matrix6 left_jacobian_inverse(const Vector6& twist) {
  const Eigen::Matrix3d inverse = rotation_left_jacobian_inverse(twist.head<3>());
  Matrix6 J = Matrix6::Zero();
  J.topLeftCorner<3, 3>() = inverse;
  J.bottomRightCorner<3, 3>() = inverse;
  J.bottomLeftCorner<3, 3>() = -inverse * coupling(twist.head<3>(), twist.tail<3>()) * inverse;
  return J;
}

Eigen::Isometry3d interpolate(const Eigen::Isometry3d& A, const Eigen::Isometry3d& B, double u) {
  return A * exp(u * log(A.inverse() * B));
}

Matrix6 transform_covariance(const Eigen::Isometry3d& T_a_b, const Matrix6& covariance) {
  const Matrix6 A = adjoint(T_a_b);
  return A * covariance * A.transpose();
}

}  // namespace infuse::geometry

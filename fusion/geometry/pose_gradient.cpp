#include "fusion/geometry/pose_gradient.hpp"

#include <algorithm>
#include <array>

#include "drivers/measurement/simd.hpp"

namespace infuse::geometry {
namespace {

constexpr size_t kLanes = 16;  // lanes, whatever the instruction set

/// Pinhole camera and pose in single precision, for the loop over the points.
struct Pinhole {
  float R[9];
  float t[3];
  float fx, fy, k1, k2, p1, p2, k3;
};

Pinhole make_pinhole(const CameraIntrinsics& intrinsics, const Eigen::Isometry3d& T) {
  Pinhole out{};
  for (int i = 0; i < 9; ++i) out.R[i] = static_cast<float>(T.linear()(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) out.t[i] = static_cast<float>(T.translation()(i));
  const auto& d = intrinsics.distortion;
  out.fx = static_cast<float>(intrinsics.fx);
  out.fy = static_cast<float>(intrinsics.fy);
  out.k1 = static_cast<float>(d[0]);
  out.k2 = static_cast<float>(d[1]);
  out.p1 = static_cast<float>(d[2]);
  out.p2 = static_cast<float>(d[3]);
  out.k3 = static_cast<float>(d[4]);
  return out;
}

/// Six sums per lane. The number of lanes is fixed, so that the order of summation is the same on
/// every processor.
using Sums = std::array<std::array<float, kLanes>, 6>;

constexpr float kMinDepth = 0.01F;  // m along the optical axis; nearer points are not projected

INFUSE_SIMD_CLONES void add_point_gradients(const Pinhole c, const float* __restrict x,
                                            const float* __restrict y, const float* __restrict z,
                                            const float* __restrict by_u,
                                            const float* __restrict by_v, size_t groups,
                                            Sums& __restrict sums) {
  for (size_t g = 0; g < groups; ++g) {
    for (size_t lane = 0; lane < kLanes; ++lane) {
      const size_t i = g * kLanes + lane;
      const float px = c.R[0] * x[i] + c.R[1] * y[i] + c.R[2] * z[i] + c.t[0];
      const float py = c.R[3] * x[i] + c.R[4] * y[i] + c.R[5] * z[i] + c.t[1];
      const float pz = c.R[6] * x[i] + c.R[7] * y[i] + c.R[8] * z[i] + c.t[2];
      // Points outside the view have zero derivatives; their other factor must be finite.
      const float inverse = 1 / (pz > kMinDepth ? pz : kMinDepth);
      const float a = px * inverse;
      const float b = py * inverse;
      const float r2 = a * a + b * b;
      const float radial = 1 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
      const float slope =
          2 *
          (c.k1 + r2 * (2 * c.k2 + 3 * r2 * c.k3));  // of `radial` with respect to a, divided by a
      const float mixed = slope * a * b + 2 * (c.p1 * a + c.p2 * b);
      const float u_a = radial + slope * a * a + 2 * c.p1 * b + 6 * c.p2 * a;
      const float v_b = radial + slope * b * b + 6 * c.p1 * b + 2 * c.p2 * a;
      const float gu = by_u[i] * c.fx;
      const float gv = by_v[i] * c.fy;
      const float gx = (gu * u_a + gv * mixed) * inverse;
      const float gy = (gu * mixed + gv * v_b) * inverse;
      const float gz = -(gx * a + gy * b);
      sums[0][lane] += py * gz - pz * gy;
      sums[1][lane] += pz * gx - px * gz;
      sums[2][lane] += px * gy - py * gx;
      sums[3][lane] += gx;
      sums[4][lane] += gy;
      sums[5][lane] += gz;
    }
  }
}

/// Gradient of one point by `project_with_derivatives`.
Vector6 point_gradient(const CameraModel& camera, const Eigen::Isometry3d& T,
                       const PointsView& points, float by_u, float by_v, size_t i) {
  if (by_u == 0 && by_v == 0) return Vector6::Zero();
  const Eigen::Vector3d point(points.x[i], points.y[i], points.z[i]);
  const auto derivatives = camera.project_with_derivatives(T * point);
  if (!derivatives) return Vector6::Zero();
  return derivatives->by_pose.transpose() * Eigen::Vector2d(by_u, by_v);
}

}  // namespace

Vector6 pose_gradient(const CameraModel& camera, const Eigen::Isometry3d& T_camera_lidar,
                      const PointsView& points, std::span<const float> by_u,
                      std::span<const float> by_v) {
  Vector6 gradient = Vector6::Zero();
  size_t done = 0;
  if (camera.intrinsics().model == CameraIntrinsics::Model::kPinhole) {
    const Pinhole constants = make_pinhole(camera.intrinsics(), T_camera_lidar);
    constexpr size_t kGroupsPerBatch = 64;  // groups summed in single precision
    const size_t groups = points.x.size() / kLanes;
    for (size_t first = 0; first < groups; first += kGroupsPerBatch) {
      Sums sums{};
      const size_t at = first * kLanes;
      add_point_gradients(constants, &points.x[at], &points.y[at], &points.z[at], &by_u[at],
                          &by_v[at], std::min(kGroupsPerBatch, groups - first), sums);
      for (int k = 0; k < 6; ++k) {
        for (const float sum : sums[static_cast<size_t>(k)]) gradient(k) += sum;
      }
    }
    done = groups * kLanes;
  }
  for (size_t i = done; i < points.x.size(); ++i) {
    gradient += point_gradient(camera, T_camera_lidar, points, by_u[i], by_v[i], i);
  }
  return gradient;
}

}  // namespace infuse::geometry

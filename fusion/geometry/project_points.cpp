#include "fusion/geometry/project_points.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "drivers/measurement/simd.hpp"

namespace infuse::geometry {
namespace {

/// Camera and pose in single precision, for the loop over the points.
struct Constants {
  float R[9], t[3];
  float fx, fy, cx, cy, limit;
  float k[5];
};

Constants make_constants(const CameraModel& camera, const Eigen::Isometry3d& T) {
  Constants c{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      c.R[3 * row + column] = static_cast<float>(T.linear()(row, column));
    }
    c.t[row] = static_cast<float>(T.translation()[row]);
  }
  const CameraIntrinsics& i = camera.intrinsics();
  c.fx = static_cast<float>(i.fx);
  c.fy = static_cast<float>(i.fy);
  c.cx = static_cast<float>(i.cx);
  c.cy = static_cast<float>(i.cy);
  c.limit = static_cast<float>(camera.limit());
  for (size_t n = 0; n < 5; ++n) c.k[n] = static_cast<float>(i.distortion[n]);
  return c;
}

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

INFUSE_SIMD_CLONES
void project_pinhole(const Constants c, const float* __restrict x, const float* __restrict y,
                     const float* __restrict z, size_t count, float* __restrict u,
                     float* __restrict v, float* __restrict depth) {
  for (size_t n = 0; n < count; ++n) {
    const float px = c.R[0] * x[n] + c.R[1] * y[n] + c.R[2] * z[n] + c.t[0];
    const float py = c.R[3] * x[n] + c.R[4] * y[n] + c.R[5] * z[n] + c.t[1];
    const float pz = c.R[6] * x[n] + c.R[7] * y[n] + c.R[8] * z[n] + c.t[2];
    const float w = 1.0f / pz;
    const float a = px * w, b = py * w;
    const float s = a * a + b * b;
    const float g = 1.0f + s * (c.k[0] + s * (c.k[1] + s * c.k[4]));
    const float da = a * g + 2.0f * c.k[2] * a * b + c.k[3] * (s + 2.0f * a * a);
    const float db = b * g + c.k[2] * (s + 2.0f * b * b) + 2.0f * c.k[3] * a * b;
    const bool seen = (pz > 0.0f) & (s <= c.limit);
    u[n] = seen ? c.fx * da + c.cx : kNaN;
    v[n] = seen ? c.fy * db + c.cy : kNaN;
    depth[n] = pz;
  }
}

INFUSE_SIMD_CLONES
void project_fisheye(const Constants c, const float* __restrict x, const float* __restrict y,
                     const float* __restrict z, size_t count, float* __restrict u,
                     float* __restrict v, float* __restrict depth) {
  constexpr float kPi = std::numbers::pi_v<float>, kHalfPi = kPi / 2, kQuarterPi = kPi / 4;
  for (size_t n = 0; n < count; ++n) {
    const float px = c.R[0] * x[n] + c.R[1] * y[n] + c.R[2] * z[n] + c.t[0];
    const float py = c.R[3] * x[n] + c.R[4] * y[n] + c.R[5] * z[n] + c.t[1];
    const float pz = c.R[6] * x[n] + c.R[7] * y[n] + c.R[8] * z[n] + c.t[2];
    const float radius = std::sqrt(px * px + py * py);
    // atan2(radius, pz): argument reduced to 0 … tan(π/8), then the polynomial of the Cephes
    // library.
    const float abs_z = pz < 0.0f ? -pz : pz;
    const float smaller = radius < abs_z ? radius : abs_z, larger = radius < abs_z ? abs_z : radius;
    const float ratio = smaller / larger;
    const float reduced = (ratio - 1.0f) / (ratio + 1.0f);
    const bool upper = ratio > 0.414213562f;
    const float q = upper ? reduced : ratio;
    const float s = q * q;
    const float p = (((8.05374449538e-2f * s - 1.38776856032e-1f) * s + 1.99777106478e-1f) * s -
                     3.33329491539e-1f) *
                        s * q +
                    q;
    const float eighth = upper ? kQuarterPi + p : p;
    const float quarter = radius > abs_z ? kHalfPi - eighth : eighth;
    const float angle = pz < 0.0f ? kPi - quarter : quarter;

    const float t = angle * angle;
    const float g = 1.0f + t * (c.k[0] + t * (c.k[1] + t * (c.k[2] + t * c.k[3])));
    const float off_axis = angle / radius, on_axis = 1.0f / pz;
    const float per_metre = radius > 1e-6f * abs_z ? off_axis : on_axis;
    const float scale = g * per_metre;
    const bool seen = (angle <= c.limit) & (larger > 0.0f);
    u[n] = seen ? c.fx * scale * px + c.cx : kNaN;
    v[n] = seen ? c.fy * scale * py + c.cy : kNaN;
    depth[n] = pz;
  }
}

}  // namespace

void project_points(const CameraModel& camera, const Eigen::Isometry3d& T_camera_lidar,
                    const PointsView& points, const PixelsView& pixels) {
  const Constants c = make_constants(camera, T_camera_lidar);
  const auto project = camera.intrinsics().model == CameraIntrinsics::Model::kPinhole
                           ? project_pinhole
                           : project_fisheye;
  project(c, points.x.data(), points.y.data(), points.z.data(), points.x.size(), pixels.u.data(),
          pixels.v.data(), pixels.depth.data());
}

}  // namespace infuse::geometry

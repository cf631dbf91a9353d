#include "fusion/registration/move_points.hpp"

#include "drivers/measurement/simd.hpp"

namespace infuse::registration {
namespace {

/// A rotation and a translation in single precision.
struct Motion {
  float r[9], t[3];
};

INFUSE_SIMD_CLONES void move(const Motion& m, const float* __restrict x, const float* __restrict y,
                             const float* __restrict z, size_t size, float* __restrict ox,
                             float* __restrict oy, float* __restrict oz) {
  for (size_t i = 0; i < size; ++i) {
    ox[i] = m.r[0] * x[i] + m.r[1] * y[i] + m.r[2] * z[i] + m.t[0];
    oy[i] = m.r[3] * x[i] + m.r[4] * y[i] + m.r[5] * z[i] + m.t[1];
    oz[i] = m.r[6] * x[i] + m.r[7] * y[i] + m.r[8] * z[i] + m.t[2];
  }
}

}  // namespace

void move_points(const Eigen::Isometry3d& T, const geometry::PointsView& points,
                 FieldVector<float>& x, FieldVector<float>& y, FieldVector<float>& z) {
  Motion motion;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) motion.r[3 * r + c] = static_cast<float>(T(r, c));
    motion.t[r] = static_cast<float>(T(r, 3));
  }
  move(motion, points.x.data(), points.y.data(), points.z.data(), points.x.size(), x.data(),
       y.data(), z.data());
}

}  // namespace infuse::registration

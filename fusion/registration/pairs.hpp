#pragma once

#include <type_traits>

#include "fusion/features/lanes.hpp"
#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/registration/point_cloud.hpp"

namespace infuse::registration {

using features::Flags;
using features::Floats;
using features::kLanes;

/// Pairs of points and their local planes as a structure of arrays in the target frame, padded to
/// whole vectors with weight 0.
struct Pairs {
  using Field = FieldVector<float>;
  Field px, py, pz;  ///< m, points of the source at the present pose
  Field sx, sy, sz;  ///< their normals
  Field qx, qy, qz;  ///< m, points of the target
  Field tx, ty, tz;  ///< their normals
  Field weight;      ///< 1, or 0: no pair
  Field tilt;        ///< rad², variance of the target's normals by noise; 0: not known
  size_t size = 0;   ///< number of pairs, with weight or not
  size_t padded() const { return (size + kLanes - 1) / kLanes * kLanes; }
  void resize(size_t pairs);
};

/// Vectors of 16 pairs side by side.
struct LaneVector {
  Floats x, y, z;
};

[[gnu::always_inline]] inline LaneVector operator+(const LaneVector& a, const LaneVector& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
[[gnu::always_inline]] inline LaneVector operator-(const LaneVector& a, const LaneVector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
[[gnu::always_inline]] inline LaneVector operator*(const Floats& s, const LaneVector& a) {
  return {s * a.x, s * a.y, s * a.z};
}
[[gnu::always_inline]] inline Floats dot(const LaneVector& a, const LaneVector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
[[gnu::always_inline]] inline LaneVector cross(const LaneVector& a, const LaneVector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double dot(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.dot(b); }

/// Vector of a factor's numbers: `Floats` (16 pairs side by side, in the sums) or `double` (one
/// pair, in the covariance).
template <class Number>
using VectorOf = std::conditional_t<std::is_same_v<Number, double>, Eigen::Vector3d, LaneVector>;

/// Scalar of a factor's numbers: float or double.
template <class Number>
using ScalarOf = std::conditional_t<std::is_same_v<Number, double>, double, float>;

/// One pair, or 16 side by side.
template <class Number>
struct Pair {
  VectorOf<Number> p;              ///< m, point of the source at the present pose
  VectorOf<Number> source_normal;  ///< 0 where there is no plane
  VectorOf<Number> q;              ///< m, point of the target
  VectorOf<Number> target_normal;  ///< 0 where there is no plane
};

}  // namespace infuse::registration

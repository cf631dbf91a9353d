#pragma once

#include <cstddef>
#include <cstdint>

namespace infuse::monitoring {

/// Axes of an evaluation: the six of a left perturbation of T_camera_lidar, the delay of the
/// camera's stamps, and rotations and delay again with wider steps, which detect drifts beyond the
/// range of the narrow one.
enum class Axis : uint8_t {
  kRotationX,
  kRotationY,
  kRotationZ,
  kTranslationX,
  kTranslationY,
  kTranslationZ,
  kTime,
  kWideRotationX,
  kWideRotationY,
  kWideRotationZ,
  kWideTime,
  kFarRotationX,
  kFarRotationY,
  kFarRotationZ,
  kFartherRotationX,
  kFartherRotationY,
  kFartherRotationZ
};
inline constexpr size_t kAxes = static_cast<size_t>(Axis::kFartherRotationZ) + 1;

/// m each axis, standard deviation of the displacement of a camera that was knocked.
inline constexpr double kKnockSigma = 0.1;

/// Returns the axis that a wide variant belongs to; other axes unchanged.
constexpr Axis base_axis(Axis axis) {
  if (axis < Axis::kWideRotationX) return axis;
  if (axis == Axis::kWideTime) return Axis::kTime;
  const Axis first = axis < Axis::kWideTime           ? Axis::kWideRotationX
                     : axis < Axis::kFartherRotationX ? Axis::kFarRotationX
                                                      : Axis::kFartherRotationX;
  return static_cast<Axis>(static_cast<uint8_t>(axis) - static_cast<uint8_t>(first));
}

/// True for rotations whose step lies beyond the peak: they are evaluated with a blurred image.
constexpr bool is_far(Axis axis) { return axis >= Axis::kFarRotationX; }

/// Returns "rotation about x", "translation along z", "time".
const char* name_of(Axis axis);

}  // namespace infuse::monitoring

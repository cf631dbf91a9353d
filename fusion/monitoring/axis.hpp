#pragma once

#include <cstddef>
#include <cstdint>

namespace infuse::monitoring {

/// Axes of an evaluation: the six of a left perturbation of T_camera_lidar, the delay of the
/// camera's stamps, and rotations and delay again with a wider step, which detects drifts beyond
/// the range of the narrow one.
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
  kWideTime
};
inline constexpr size_t kAxes = 11;

/// Returns the axis that a wide variant belongs to; other axes unchanged.
constexpr Axis base_axis(Axis axis) {
  if (axis < Axis::kWideRotationX) return axis;
  if (axis == Axis::kWideTime) return Axis::kTime;
  return static_cast<Axis>(static_cast<uint8_t>(axis) - static_cast<uint8_t>(Axis::kWideRotationX));
}

/// Returns "rotation about x", "translation along z", "time".
const char* name_of(Axis axis);

}  // namespace infuse::monitoring

#pragma once

#include <cstdint>
#include <numbers>

namespace infuse::lidar {

/// A turn, in the unit of azimuths: 0.01°, clockwise from above, 0 at the lidar frame's x axis.
inline constexpr int kCentidegreesPerTurn = 36'000;
/// The unit of azimuths, rad.
inline constexpr double kCentidegree = std::numbers::pi / 18000;
/// Stands for an azimuth that cannot be the sensor's, until `repair_azimuths` has replaced it.
inline constexpr uint16_t kNoAzimuth = 0xFFFF;

/// Returns the difference of two azimuths in the direction of rotation, 0.01°: 0 … 35999. A step
/// back of up to one degree (a jittering encoder, a sensor at rest) is negative.
constexpr int azimuth_advance(int from, int to) {
  constexpr int kMaxBackwardStep = 100;  // 0.01°
  const int advance = (to - from + 2 * kCentidegreesPerTurn) % kCentidegreesPerTurn;
  return advance >= kCentidegreesPerTurn - kMaxBackwardStep ? advance - kCentidegreesPerTurn
                                                            : advance;
}

}  // namespace infuse::lidar

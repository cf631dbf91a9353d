#pragma once

#include <algorithm>
#include <cmath>

#include "drivers/measurement/vehicle_samples.hpp"

namespace infuse::motion {

/// Number of speeds in a sample of the wheels.
inline int measured_speeds(const WheelOdometry& sample) {
  const auto wheels = std::count_if(sample.wheel_speed.begin(), sample.wheel_speed.end(),
                                    [](double v) { return std::isfinite(v); });
  return static_cast<int>(wheels) + (std::isfinite(sample.speed) ? 1 : 0);
}

/// Smallest change of the speed of a wheel, with its sign, m/s.
inline double smallest_change(const WheelOdometry& from, const WheelOdometry& to) {
  double smallest = to.speed - from.speed;
  for (size_t i = 0; i < to.wheel_speed.size(); ++i) {
    const double change = to.wheel_speed[i] - from.wheel_speed[i];
    if (std::isnan(smallest) || std::abs(change) < std::abs(smallest)) smallest = change;
  }
  return smallest;
}

/// True if no speed of a sample is greater than `standstill_speed`, m/s.
inline bool is_at_rest(const WheelOdometry& sample, double standstill_speed) {
  const auto turns = [&](double v) { return std::abs(v) > standstill_speed; };
  return std::none_of(sample.wheel_speed.begin(), sample.wheel_speed.end(), turns) &&
         !turns(sample.speed);
}

}  // namespace infuse::motion

#include "drivers/hesai/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "drivers/measurement/angles.hpp"

namespace infuse::hesai {

std::optional<std::string> Calibration::invalid(const ModelInfo& info) const {
  constexpr double kMaxElevation = 60 * kDegree;
  constexpr double kMaxAzimuthOffset = 30 * kDegree;
  const auto within = [](double value, double limit) {
    return std::isfinite(value) && std::abs(value) <= limit;
  };
  for (size_t channel = 0; channel < info.lasers; ++channel) {
    const BeamAngles& beam = beams[channel];
    const std::string suffix = " of channel " + std::to_string(channel + 1) + " is out of range";
    if (!within(beam.elevation, kMaxElevation)) return "elevation" + suffix;
    if (!within(beam.azimuth_offset, kMaxAzimuthOffset)) return "azimuth" + suffix;
    for (size_t other = 0; other < channel; ++other) {
      if (beams[other].elevation == beam.elevation &&
          beams[other].azimuth_offset == beam.azimuth_offset) {
        return "channels " + std::to_string(other + 1) + " and " + std::to_string(channel + 1) +
               " have the same direction";
      }
    }
  }
  return std::nullopt;
}

std::array<uint16_t, kMaxLasers> Calibration::rings(const ModelInfo& info) const {
  std::array<uint16_t, kMaxLasers> by_elevation{};
  std::iota(by_elevation.begin(), by_elevation.end(), static_cast<uint16_t>(0));
  std::sort(by_elevation.begin(), by_elevation.begin() + info.lasers, [&](uint16_t a, uint16_t b) {
    return std::pair(beams[a].elevation, a) < std::pair(beams[b].elevation, b);
  });
  std::array<uint16_t, kMaxLasers> rings{};
  for (uint16_t ring = 0; ring < info.lasers; ++ring) rings[by_elevation[ring]] = ring;
  return rings;
}

}  // namespace infuse::hesai

#include "drivers/velodyne/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace infuse::velodyne {
namespace {

bool within(double value, double limit) { return std::isfinite(value) && std::abs(value) <= limit; }

}  // namespace

std::optional<std::string> Calibration::invalid(const ModelInfo& info) const {
  constexpr double kMaxElevation = 1.0;  // rad
  constexpr double kMaxRotation = 0.8;   // rad
  constexpr double kMaxDistance = 10;    // m
  constexpr double kMaxOffset = 2;       // m
  for (size_t laser = 0; laser < info.lasers; ++laser) {
    const BeamCorrection& beam = beams[laser];
    const std::string suffix = " of laser " + std::to_string(laser) + " is out of range";
    if (!within(beam.elevation, kMaxElevation)) return "vertical correction" + suffix;
    if (!within(beam.rotation, kMaxRotation)) return "rotational correction" + suffix;
    for (const double distance : {beam.distance, beam.distance_x, beam.distance_y}) {
      if (!within(distance, kMaxDistance)) return "distance correction" + suffix;
    }
    for (const double offset : {beam.vertical_offset, beam.horizontal_offset}) {
      if (!within(offset, kMaxOffset)) return "offset" + suffix;
    }
    if (!within(beam.focal_distance, 1000)) return "focal distance" + suffix;
    if (!within(beam.focal_slope, 1000)) return "focal slope" + suffix;
    if (!(beam.min_intensity >= 0 && beam.min_intensity <= beam.max_intensity &&
          beam.max_intensity <= 255)) {
      return "intensity limits" + suffix;
    }
  }
  return std::nullopt;
}

std::array<uint16_t, kMaxSlots> Calibration::rings(const ModelInfo& info) const {
  std::array<uint16_t, kMaxSlots> by_elevation{};
  std::iota(by_elevation.begin(), by_elevation.end(), static_cast<uint16_t>(0));
  std::sort(by_elevation.begin(), by_elevation.begin() + info.lasers, [&](uint16_t a, uint16_t b) {
    return std::pair(beams[a].elevation, a) < std::pair(beams[b].elevation, b);
  });
  std::array<uint16_t, kMaxSlots> rings{};
  for (uint16_t ring = 0; ring < info.lasers; ++ring) rings[by_elevation[ring]] = ring;
  return rings;
}

}  // namespace infuse::velodyne

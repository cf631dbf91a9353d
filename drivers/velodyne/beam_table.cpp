#include "drivers/velodyne/beam_table.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {
namespace {

constexpr double kMaxTurnsPerSecond = 30;
constexpr double kFocalRange = 131;  // m, from the HDL-64E manual

float correction_slope(double near, double near_at, double far) {
  return static_cast<float>((far - near) / (static_cast<double>(kFarDistance) - near_at));
}

}  // namespace

int max_azimuth_step(const ModelInfo& info) {
  // The firmware of a VLS-128 may run 5 % slower than the nominal cycle.
  const double period_s = 1.05 * to_seconds(sequence_period(info, info.cycle));
  return static_cast<int>(std::ceil(kMaxTurnsPerSecond * 36'000 * period_s));
}

BeamTable::BeamTable(Model model, const Calibration& calibration, Duration firing_cycle)
    : info(&model_info(model)),
      max_step(max_azimuth_step(*info)),
      distance_unit(static_cast<float>(info->distance_unit_mm * 1e-3)),
      forward_rows(static_cast<size_t>(max_step + 1) * info->slots()),
      right_rows(forward_rows.size()) {
  rebuild(calibration, firing_cycle);
}

void BeamTable::rebuild(const Calibration& calibration, Duration firing_cycle) {
  cycle = firing_cycle;
  time_ns = firing_times(*info, cycle);
  last_firing_ns = *std::max_element(time_ns.begin(), time_ns.end());
  const std::array<uint16_t, kMaxSlots> rings = calibration.rings(*info);
  const auto period_ns = static_cast<double>(sequence_period(*info, cycle).count());
  for (size_t slot = 0; slot < info->slots(); ++slot) {
    const size_t laser = slot % info->lasers;
    const BeamCorrection& beam = calibration.beams[laser];
    ring[slot] = rings[laser];
    sin_elevation[slot] = static_cast<float>(std::sin(beam.elevation));
    cos_elevation[slot] = static_cast<float>(std::cos(beam.elevation));
    far_correction[slot] = static_cast<float>(beam.distance);
    const bool two_points = beam.distance_x != 0 || beam.distance_y != 0;
    const double near_distance_x = two_points ? beam.distance_x : beam.distance;
    const double near_distance_y = two_points ? beam.distance_y : beam.distance;
    near_x[slot] = static_cast<float>(near_distance_x);
    near_y[slot] = static_cast<float>(near_distance_y);
    slope_x[slot] = correction_slope(near_distance_x, kNearDistanceX, beam.distance);
    slope_y[slot] = correction_slope(near_distance_y, kNearDistanceY, beam.distance);
    horizontal_offset[slot] = static_cast<float>(beam.horizontal_offset);
    vertical_offset[slot] = static_cast<float>(beam.vertical_offset);
    focal_slope[slot] = static_cast<float>(256 * beam.focal_slope);
    focal_term[slot] = static_cast<float>(std::pow(1 - beam.focal_distance / kFocalRange, 2));
    min_intensity[slot] = static_cast<float>(beam.min_intensity);
    max_intensity[slot] = static_cast<float>(beam.max_intensity);

    const double horizontal = info->calibrated_per_unit ? 1.0 : std::cos(beam.elevation);
    const double turned = static_cast<double>(time_ns[slot]) / period_ns;
    for (size_t step = 0; step <= static_cast<size_t>(max_step); ++step) {
      const double azimuth = static_cast<double>(step) * turned * kCentidegree - beam.rotation;
      forward_rows[step * info->slots() + slot] =
          static_cast<float>(horizontal * std::cos(azimuth));
      right_rows[step * info->slots() + slot] = static_cast<float>(horizontal * std::sin(azimuth));
    }
  }
}

}  // namespace infuse::velodyne

#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/measurement/sweep.hpp"
#include "drivers/velodyne/calibration.hpp"
#include "drivers/velodyne/model.hpp"

namespace infuse::velodyne {

/// Step of azimuth, 0.01°, between two firing sequences above which a model does not turn (30 turns
/// per second), but jumps.
int max_azimuth_step(const ModelInfo& info);

/// Packet-independent data of one sensor's beams, laid out for the decoder.
///
/// During a firing sequence the sensor turns by a whole number of hundredths of a degree, the
/// *step* to the next sequence's azimuth. The directions of all slots relative to the sequence's
/// own azimuth are therefore tables, exact, one row per step; one rotation in the plane converts
/// them to the lidar frame.
struct BeamTable {
  /// One entry per slot.
  template <class T>
  using PerSlot = std::array<T, kMaxSlots>;

  /// Allocates; the calibration must be valid for the model.
  BeamTable(Model model, const Calibration& calibration, Duration cycle);

  /// Rebuilds the tables for another calibration or firing cycle of the same model; allocates
  /// nothing.
  void rebuild(const Calibration& calibration, Duration cycle);

  /// The row of directions of a step in 0 … max_step, one entry per slot.
  const float* forward(size_t step) const { return forward_rows.data() + step * info->slots(); }
  const float* right(size_t step) const { return right_rows.data() + step * info->slots(); }

  const ModelInfo* info;
  Duration cycle{0};           ///< ns; firing cycle
  int max_step = 0;            ///< 0.01°; see `max_azimuth_step`
  int32_t last_firing_ns = 0;  ///< firing time of the last slot, after the sequence's start
  float distance_unit = 0;     ///< m; unit of a packet's distance

  alignas(64) PerSlot<int32_t> time_ns{};  ///< firing time of the slot, after the sequence's start
  PerSlot<int32_t> ring{};                 ///< by elevation from below
  PerSlot<float> sin_elevation{};

  /// The following arrays are used only if units are calibrated individually (HDL-64E); in metres.
  PerSlot<float> cos_elevation{};
  PerSlot<float> far_correction{};
  PerSlot<float> near_x{}, slope_x{};  ///< correction at 2.40 m along x, and its growth per metre
  PerSlot<float> near_y{}, slope_y{};  ///< correction at 1.93 m along y, and its growth per metre
  PerSlot<float> horizontal_offset{}, vertical_offset{};
  PerSlot<float> focal_slope{}, focal_term{};  ///< 256·slope, (1 − focal/131 m)²
  PerSlot<float> min_intensity{}, max_intensity{};

  /// Horizontal direction of each slot at sequence azimuth 0, one row per step. Includes the cosine
  /// of elevation, unless units are calibrated individually.
  std::vector<float> forward_rows, right_rows;
};

/// Distances at which the two-point correction of an HDL-64E is given, m.
inline constexpr float kNearDistanceX = 2.40F, kNearDistanceY = 1.93F, kFarDistance = 25.04F;

}  // namespace infuse::velodyne

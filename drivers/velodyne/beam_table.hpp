#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/measurement/sweep.hpp"
#include "drivers/velodyne/calibration.hpp"
#include "drivers/velodyne/model.hpp"

namespace infuse::velodyne {

/// What is the same from packet to packet: the beams of one sensor as the decoder wants them.
///
/// While a firing sequence lasts the sensor turns by a whole number of hundredths of a degree, the
/// *step* to the next sequence's azimuth. So the directions of all slots, relative to the
/// sequence's own azimuth, are tables: one row a step, exact, from which one rotation of the plane
/// leads to the lidar frame.
struct BeamTable {
  /// By slot.
  template <class T>
  using PerSlot = std::array<T, kMaxSlots>;

  /// Allocates; the calibration must be valid for the model.
  BeamTable(Model model, const Calibration& calibration, Duration cycle);

  /// For another calibration or firing cycle of the same model; allocates nothing.
  void rebuild(const Calibration& calibration, Duration cycle);

  /// The row of directions of a step in 0 … max_step, an entry a slot.
  const float* forward(size_t step) const { return forward_rows.data() + step * info->slots(); }
  const float* right(size_t step) const { return right_rows.data() + step * info->slots(); }

  const ModelInfo* info;
  Duration cycle{0};           ///< ns; firing cycle
  int max_step = 0;            ///< 0.01°; a larger step is no rotation (above 30 turns a second)
  int32_t last_firing_ns = 0;  ///< when the last slot fires, after the sequence's start
  float distance_unit = 0;     ///< m; of a packet's distance

  alignas(64) PerSlot<int32_t> time_ns{};  ///< when the slot fires, after the sequence's start
  PerSlot<int32_t> ring{};                 ///< by elevation from below
  PerSlot<float> sin_elevation{};

  /// Only where units are calibrated one by one (HDL-64E): all in metres.
  PerSlot<float> cos_elevation{};
  PerSlot<float> far_correction{};
  PerSlot<float> near_x{}, slope_x{};  ///< correction at 2.40 m along x, and its growth a metre
  PerSlot<float> near_y{}, slope_y{};  ///< correction at 1.93 m along y, and its growth a metre
  PerSlot<float> horizontal_offset{}, vertical_offset{};
  PerSlot<float> focal_slope{}, focal_term{};  ///< 256·slope, (1 − focal/131 m)²
  PerSlot<float> min_intensity{}, max_intensity{};

  /// Horizontal direction of each slot where the sequence's azimuth is 0, a row a step; includes
  /// the cosine of elevation, except where units are calibrated one by one.
  std::vector<float> forward_rows, right_rows;
};

/// Where the two-point correction of an HDL-64E is known, m.
inline constexpr float kNearDistanceX = 2.40F, kNearDistanceY = 1.93F, kFarDistance = 25.04F;

}  // namespace infuse::velodyne

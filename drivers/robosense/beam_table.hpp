#pragma once

#include <array>
#include <cstdint>

#include "drivers/measurement/sweep.hpp"
#include "drivers/robosense/calibration.hpp"

namespace infuse::robosense {

/// Packet-independent data of one sensor's beams, laid out for the decoder by *slot*: the place of
/// a unit in a block of one return. Of an RS-Helios-16P the slots 16 … 31 are the second firing of
/// its 16 channels.
///
/// A unit's azimuth is its block's, plus the part of the step to the next block by which the rotor
/// turns until it fires, plus the channel's offset. The second is a table, one row for each step in
/// 0.01°. Beams begin before the axis of rotation, in the direction of the rotor's azimuth. Of a
/// sensor that turns anticlockwise azimuths are those of its mirror image.
class BeamTable {
 public:
  /// One entry per slot.
  template <class T>
  using PerSlot = std::array<T, kChannels>;

  /// Horizontal directions of the slots at block azimuth 0, times the cosine of elevation, and the
  /// origins of their beams, m.
  struct Row {
    const float *forward, *right, *origin_forward, *origin_right;
  };

  /// Allocates; the calibration must be valid for the model. `single_origin`: all beams begin in
  /// the axis of rotation.
  BeamTable(Model model, const Calibration& calibration, bool single_origin);

  /// Changes the calibration, or the number of returns. Allocates nothing.
  void rebuild(const Calibration& calibration, bool dual);

  /// The directions at a step of the azimuth, 0.01°, from one block to the next.
  Row row(uint16_t step) const;

  const Calibration& calibration() const { return calibration_; }
  const ModelInfo& info() const { return *info_; }
  bool dual() const { return dual_; }
  /// −1 if the sensor turns anticlockwise, else 1: factor of the sine of an azimuth.
  float side() const { return calibration_.anticlockwise ? -1.0F : 1.0F; }
  int32_t period_ns() const;  ///< from one block to the next (of two blocks of one firing: pair)
  int32_t last_firing_ns() const;                               ///< of a sequence, after its start
  const PerSlot<int32_t>& time_ns() const { return time_ns_; }  ///< after the sequence's start
  const PerSlot<int32_t>& ring() const { return ring_; }        ///< by elevation from below
  const PerSlot<float>& sin_elevation() const { return sin_elevation_; }

 private:
  const ModelInfo* info_;
  Calibration calibration_;
  double origin_;  ///< m
  bool dual_ = false;
  alignas(64) PerSlot<int32_t> time_ns_{};
  PerSlot<int32_t> ring_{};
  PerSlot<float> sin_elevation_{};
  FieldVector<float> forward_, right_, origin_forward_, origin_right_;  ///< by step and slot
};

/// Largest step of the azimuth from one block to the next, 0.01°.
int max_step(const ModelInfo& info);

}  // namespace infuse::robosense

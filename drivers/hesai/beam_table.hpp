#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/hesai/calibration.hpp"
#include "drivers/hesai/firing_times.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::hesai {

/// Packet-independent data of one sensor's beams, laid out for the decoder.
///
/// A channel's azimuth is its block's, plus the angle by which the rotor turns until the channel
/// fires, plus the channel's offset. The second is the speed of the motor, a whole number of turns
/// per minute, times the channel's firing time: the directions of all channels relative to their
/// block are tables, one row per speed, computed when a speed first occurs. One rotation in the
/// plane converts them to the lidar frame.
class BeamTable {
 public:
  /// One entry per channel.
  template <class T>
  using PerChannel = std::array<T, kMaxLasers>;

  /// Horizontal directions of the channels of one firing at block azimuth 0, times the cosine of
  /// elevation.
  struct Row {
    const float* forward;
    const float* right;
  };

  /// Allocates; the calibration must be valid for the model.
  BeamTable(Model model, const Calibration& calibration);

  /// The directions at a speed of the motor (rpm) in a firing sequence (`loop`, QT128: 0 or 1); a
  /// speed that no motor has counts as 0. Allocates nothing.
  Row row(uint16_t motor_speed, size_t loop);

  /// Firing time of each channel after the first, ns.
  const int32_t* times(size_t loop) const { return time_ns_[loop].data(); }

  /// Firing times of a sequence, from the model.
  const FiringTimes& firing(size_t loop) const { return firing_[loop]; }

  const ModelInfo& info() const { return *info_; }
  const PerChannel<int32_t>& ring() const { return ring_; }  ///< by elevation from below
  const PerChannel<float>& sin_elevation() const { return sin_elevation_; }

 private:
  void fill(size_t row, double turned_per_ns, size_t loop);

  const ModelInfo* info_;
  Calibration calibration_;
  alignas(64) std::array<PerChannel<int32_t>, 2> time_ns_{};
  PerChannel<int32_t> ring_{};
  PerChannel<float> sin_elevation_{};
  std::array<FiringTimes, 2> firing_;
  std::vector<bool> filled_;  ///< rows in use
  FieldVector<float> forward_, right_;
};

}  // namespace infuse::hesai

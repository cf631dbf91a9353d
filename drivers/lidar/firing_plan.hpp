#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/lidar/azimuth.hpp"

namespace infuse::lidar {

/// Maximum number of firing sequences in a packet of any maker.
inline constexpr size_t kMaxSequences = 32;

/// Time and azimuth of one firing sequence: the data that share one azimuth in a packet.
struct PlannedSequence {
  uint16_t azimuth = 0;  ///< 0.01°, at its start
  uint16_t step = 0;     ///< 0.01°, turned until the next sequence starts
  /// Angle, 0.01°, turned since the start of the previous sequence; 0 for a packet's first.
  int32_t advance = 0;
  bool after_jump = false;  ///< true if the sensor skipped a part of the turn before this sequence
  int64_t time_ns = 0;      ///< start, after the packet's counter
};

/// The firing sequences of one packet.
struct FiringPlan {
  std::array<PlannedSequence, kMaxSequences> sequences{};
  size_t count = 0;
  size_t last_jump = 0;  ///< the last sequence after a jump; 0: there is none

  const PlannedSequence& last() const { return sequences[count - 1]; }
};

/// Known data of the following packet.
struct FollowingPacket {
  uint16_t azimuth = 0;  ///< 0.01°, of its first sequence
  int64_t delay_ns = 0;  ///< its counter minus this packet's
};

/// Timing of a sensor's firing sequences.
struct SequenceTiming {
  int64_t period_ns = 0;  ///< from one sequence to the next
  int max_step = 0;       ///< 0.01°; a larger step is a jump, not a rotation
};

/// Plans azimuth, step and time of each sequence in a packet whose sequences begin at `azimuths`
/// (0.01°, at most `kMaxSequences`). Azimuth is linear from sequence to sequence. The last step
/// comes from the following packet if that follows directly; otherwise it is the step before it
/// (`previous_step` if there is none). Over a jump inside the packet (a sensor configured to scan a
/// part of the turn) nothing is interpolated; the sequences after it are timed backwards from the
/// following packet, whose azimuth shows how many sequences lie between, or by the rate of rotation
/// without one. `rate`: 0.01° per ns; 0: unknown, that of the step before applies.
void plan_firings(std::span<const uint16_t> azimuths,
                  const std::optional<FollowingPacket>& following, int previous_step, double rate,
                  const SequenceTiming& timing, FiringPlan& plan);

}  // namespace infuse::lidar

#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {

/// When and where the sensor looked while one firing sequence lasted.
struct PlannedSequence {
  uint16_t azimuth = 0;  ///< 0.01°, when it started
  uint16_t step = 0;     ///< 0.01°, turned until the next sequence started
  int32_t advance = 0;  ///< 0.01°, turned since the sequence before started; 0 for a packet's first
  bool after_jump = false;  ///< the sensor has looked at nothing since the sequence before
  int64_t time_ns = 0;      ///< start, after the packet's counter
};

/// The firing sequences of one packet.
struct FiringPlan {
  std::array<PlannedSequence, kBlocks> sequences{};
  size_t count = 0;

  const PlannedSequence& last() const { return sequences[count - 1]; }
};

/// What is known of the packet that follows.
struct FollowingPacket {
  uint16_t azimuth = 0;  ///< 0.01°, of its first sequence
  int64_t delay_ns = 0;  ///< its counter minus this packet's
};

/// How a sensor's firing sequences follow each other.
struct SequenceTiming {
  int64_t period_ns = 0;  ///< from a sequence to the next
  int max_step = 0;       ///< 0.01°; more is a jump, not a rotation
};

/// From one azimuth to another in the direction of rotation, 0.01°: 0 … 35999, but a step back of
/// up to a degree (a jittering encoder, a sensor that does not turn) is negative.
int azimuth_advance(int from, int to);

/// Azimuth, its growth, and time of each sequence in a packet. Azimuth is linear from sequence to
/// sequence; the last one's growth comes from the following packet where that follows at once,
/// otherwise it is the growth before it (`previous_step` where there is none). Over a jump inside
/// the packet (a sensor told to look at a part of the turn) nothing is interpolated; what comes
/// after it is timed back from the following packet, or by the rate of rotation without one.
FiringPlan plan_firings(const Packet& packet, const std::optional<FollowingPacket>& following,
                        int previous_step, const SequenceTiming& timing);

}  // namespace infuse::velodyne

#pragma once

#include <cstdint>
#include <span>

#include "drivers/measurement/sweep.hpp"
#include "drivers/velodyne/beam_table.hpp"
#include "drivers/velodyne/firing_plan.hpp"
#include "drivers/velodyne/packet.hpp"
#include "drivers/velodyne/return_kernel.hpp"

namespace infuse::velodyne {

/// A packet that is being decoded, and the time of its counter.
struct TimedPacket {
  PacketBytes bytes;
  const Packet& packet;
  int64_t device_ns;  ///< of the counter, unwrapped
};

/// Fills one sweep. While it is open the sweep's arrays are longer than their content.
class SweepWriter {
 public:
  explicit SweepWriter(ReturnKernel kernel) : kernel_(kernel) {}

  bool is_open() const { return sweep_ != nullptr; }

  /// Begins an empty sweep whose first sequence starts at `device_ns` and `stamp`.
  void open(Sweep& sweep, uint16_t rings, int64_t device_ns, Stamp stamp);

  /// True if a sequence that starts at `device_ns` still belongs to a sweep of `max_span`.
  bool accepts(int64_t device_ns, Duration max_span) const;

  /// Appends sequences `first` … `last` − 1 of a plan. Without `interpolate` all returns of a
  /// sequence have its azimuth.
  void append(const BeamTable& table, const TimedPacket& timed, const FiringPlan& plan,
              size_t first, size_t last, bool interpolate);

  /// Adds a gap without data between these azimuths (0.01°).
  void add_gap(int from, int to);

  /// Counts missing packets.
  void add_lost_packets(uint32_t packets) { sweep_->lost_packets += packets; }

  /// Completes the sweep: sizes, span, and the gap to a whole turn.
  void close(const ClockState& clock, uint64_t sequence);

 private:
  void make_room(size_t returns);

  ReturnKernel kernel_;
  Sweep* sweep_ = nullptr;
  size_t size_ = 0;  ///< number of returns so far
  int64_t first_device_ns_ = 0;
  int64_t last_firing_ns_ = 0;  ///< after the first
  int first_azimuth_ = 0;       ///< 0.01°
  int last_azimuth_ = 0;        ///< 0.01°
  int last_step_ = 0;           ///< 0.01°
  int64_t turned_ = 0;          ///< 0.01°, from the first sequence to the last
};

}  // namespace infuse::velodyne

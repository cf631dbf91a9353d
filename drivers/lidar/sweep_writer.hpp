#pragma once

#include <cmath>
#include <cstdint>

#include "drivers/lidar/azimuth.hpp"
#include "drivers/lidar/firing_plan.hpp"
#include "drivers/lidar/return_arrays.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::lidar {

/// Fills one sweep. While it is open the sweep's arrays are longer than their content.
///
/// A decoder appends the returns of a packet's sequences so:
///
///     for (each sequence) places[i] = writer.add_sequence(sequence, device_ns, columns);
///     const ReturnArrays arrays = writer.make_room(most);
///     size_t size = writer.size();
///     for (each return) arrays.set(size++, ...);
///     writer.set_size(size, last_firing_ns);
///
/// or, where it need not be fast:
///
///     for (each sequence) {
///       writer.add_sequence(sequence, device_ns, 1);
///       for (each return) writer.add_return(ring, range, elevation);
///     }
class SweepWriter {
 public:
  /// Place of a firing sequence in the sweep.
  struct Place {
    uint16_t column = 0;         ///< of its first firing
    int32_t time_offset_ns = 0;  ///< its start, after the sweep's first firing
  };

  bool is_open() const { return sweep_ != nullptr; }

  /// Begins an empty sweep of a sensor with so many beams, whose first sequence starts at
  /// `device_ns` and `stamp`.
  void open(Sweep& sweep, uint16_t rings, int64_t device_ns, Stamp stamp);

  /// True if a sequence that starts at `device_ns` still belongs to a sweep of `max_span`.
  bool accepts(int64_t device_ns, Duration max_span) const;

  /// Adds a firing sequence that starts at `device_ns` and consists of so many firings.
  Place add_sequence(const PlannedSequence& planned, int64_t device_ns, uint16_t columns) {
    const Place place{static_cast<uint16_t>(sweep_->columns),
                      static_cast<int32_t>(device_ns - first_device_ns_)};
    if (sweep_->columns == 0) {
      first_azimuth_ = planned.azimuth;
    } else {
      turned_ += planned.advance;
    }
    sweep_->columns += columns;
    last_azimuth_ = planned.azimuth;
    last_step_ = planned.step;
    last_sequence_ns_ = place.time_offset_ns;
    return place;
  }

  /// Adds a return of the last sequence, which consists of one firing at its start: its range (m)
  /// and the elevation (rad) of its beam, which passes through the origin. For decoders that are
  /// simple rather than fast.
  void add_return(uint16_t ring, double range, double elevation) {
    const double azimuth = last_azimuth_ * kCentidegree, flat = range * std::cos(elevation);
    make_room(1).set(size_, {.x = static_cast<float>(flat * std::cos(azimuth)),
                             .y = static_cast<float>(-flat * std::sin(azimuth)),
                             .z = static_cast<float>(range * std::sin(elevation)),
                             .range = static_cast<float>(range),
                             .ring = ring,
                             .column = static_cast<uint16_t>(sweep_->columns - 1),
                             .time_offset_ns = static_cast<int32_t>(last_sequence_ns_)});
    set_size(size_ + 1, 0);
  }

  /// The sweep's arrays, with room for so many returns more.
  ReturnArrays make_room(size_t returns);

  /// Number of returns so far.
  size_t size() const { return size_; }

  /// States how many returns the arrays hold now, and when the last firing of a sequence is, ns
  /// after the sequence's start.
  void set_size(size_t size, int32_t last_firing_ns) {
    size_ = size;
    last_firing_ns_ = last_sequence_ns_ + last_firing_ns;
  }

  /// Adds a gap without data between these azimuths (0.01°).
  void add_gap(int from, int to);

  /// Counts missing packets.
  void add_lost_packets(uint32_t packets) { sweep_->lost_packets += packets; }

  /// Completes the sweep: sizes, span, and the gap to a whole turn.
  void close(const ClockState& clock, uint64_t sequence);

 private:
  Sweep* sweep_ = nullptr;
  size_t size_ = 0;
  int64_t first_device_ns_ = 0;
  int64_t last_sequence_ns_ = 0;  ///< start of the last sequence, after the first
  int64_t last_firing_ns_ = 0;    ///< after the first
  int first_azimuth_ = 0;         ///< 0.01°
  int last_azimuth_ = 0;          ///< 0.01°
  int last_step_ = 0;             ///< 0.01°
  int64_t turned_ = 0;            ///< 0.01°, from the first sequence to the last
};

}  // namespace infuse::lidar

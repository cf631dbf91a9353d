#pragma once

#include <cstdint>
#include <span>

#include "drivers/measurement/sweep.hpp"
#include "drivers/ouster/metadata.hpp"
#include "drivers/ouster/packet.hpp"
#include "drivers/ouster/return_kernel.hpp"
#include "drivers/ouster/turn_grid.hpp"

namespace infuse::ouster {

/// Fills one sweep with columns. While it is open the sweep's arrays are longer than their content.
class TurnWriter {
 public:
  /// `grid` must outlive this object.
  TurnWriter(const Metadata& metadata, const TurnGrid& grid, InstructionSet set);

  bool is_open() const { return sweep_ != nullptr; }

  /// Begins an empty sweep whose first column fires at `device_ns` and `stamp`.
  void open(Sweep& sweep, int64_t device_ns, Stamp stamp);

  /// True if a column that fires at `device_ns` still belongs to a sweep of `max_span`.
  bool accepts(int64_t device_ns, Duration max_span) const {
    const int64_t after_ns = device_ns - first_device_ns_;
    return after_ns >= 0 && after_ns < max_span.count();
  }

  /// Appends the valid ones of a packet's columns, which all belong to this sweep.
  void append(std::span<const Column> columns);

  /// Counts missing packets.
  void add_lost_packets(uint32_t packets) { sweep_->lost_packets += packets; }

  /// Completes the sweep.
  void close(const ClockState& clock, uint64_t sequence);

 private:
  void note_column(int index);
  void add_gap(int from, int to);
  double azimuth(int index) const;

  const TurnGrid& grid_;
  BeamTable table_;
  ReturnKernel kernel_;
  FirstReturn first_return_;
  size_t echoes_;
  double zero_azimuth_;  ///< rad, lidar frame, of index 0

  Sweep* sweep_ = nullptr;
  size_t size_ = 0;
  int64_t first_device_ns_ = 0;
  int64_t last_device_ns_ = 0;
  int first_index_ = 0;  ///< of the sweep's first column
  int next_index_ = 0;   ///< behind the latest column
};

}  // namespace infuse::ouster

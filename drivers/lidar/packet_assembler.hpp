#pragma once

#include <optional>

#include "drivers/lidar/arrival_order.hpp"
#include "drivers/lidar/firing_plan.hpp"
#include "drivers/lidar/packet_header.hpp"
#include "drivers/measurement/clock_model.hpp"
#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::lidar {

/// Assembles the data packets of one sensor into sweeps. `SweepAssembler` is that of sensors whose
/// packets state azimuths; a maker whose packets number turns and columns has its own.
class PacketAssembler {
 public:
  virtual ~PacketAssembler() = default;

  /// Adds a valid data packet. Returns its place among the others if it is used; otherwise it is
  /// counted with the reason. `pull` must have returned false since the last push.
  virtual std::optional<ArrivalOrder::Verdict> push(const Datagram& datagram,
                                                    const PacketHeader& header) = 0;

  /// Counts a packet that has arrived, but was refused: it is not lost.
  virtual void note_refused() = 0;

  /// Throws std::logic_error if a packet waits for `pull`.
  virtual void require_pulled() const = 0;

  /// Decodes into `sweep`. True: the sweep is complete, call again with an empty one. False: all
  /// available data is decoded; pass the same sweep again after the next push.
  virtual bool pull(Sweep& sweep) = 0;

  /// Ends the stream: `pull` until false returns the remaining data.
  virtual void finish() = 0;

  /// Continues the stream after `finish`.
  virtual void resume() = 0;

  /// Changes the timing of sequences, where packets do not state the time of each.
  virtual void set_timing(const SequenceTiming&) {}

  /// The device's clock.
  virtual ClockModel& clock() = 0;
  virtual const ClockModel& clock() const = 0;
};

}  // namespace infuse::lidar

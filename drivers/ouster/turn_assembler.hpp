#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/lidar/arrival_order.hpp"
#include "drivers/lidar/decoder_options.hpp"
#include "drivers/lidar/losses.hpp"
#include "drivers/lidar/packet_assembler.hpp"
#include "drivers/lidar/packet_counters.hpp"
#include "drivers/measurement/clock_model.hpp"
#include "drivers/measurement/datagram.hpp"
#include "drivers/ouster/packet.hpp"
#include "drivers/ouster/turn_grid.hpp"
#include "drivers/ouster/turn_writer.hpp"

namespace infuse::ouster {

/// Assembles the lidar packets of one sensor into sweeps, written directly into the caller's
/// `Sweep`. The sensor numbers its turns and columns, so that sweeps, lost packets and the columns
/// of returns are known exactly; nothing is inferred from angles or times.
///
/// A sweep holds the columns of one turn, or of the part that the sensor sends. A packet is decoded
/// when the next one has arrived, so that one that is late by one is put back in order.
class TurnAssembler final : public lidar::PacketAssembler {
 public:
  /// The options must be valid. Counts into `counters` and `losses`, which must outlive this
  /// object.
  TurnAssembler(const Metadata& metadata, const lidar::DecoderOptions& options,
                const ClockModelOptions& clock, lidar::PacketCounters& counters,
                lidar::Losses& losses);

  TurnAssembler(const TurnAssembler&) = delete;
  TurnAssembler& operator=(const TurnAssembler&) = delete;

  std::optional<lidar::ArrivalOrder::Verdict> push(const Datagram& datagram,
                                                   const lidar::PacketHeader& header) override;
  void note_refused() override { ++refused_; }
  void require_pulled() const override;
  bool pull(Sweep& sweep) override;
  void finish() override { finished_ = true; }
  void resume() override { finished_ = false; }
  ClockModel& clock() override { return clock_; }
  const ClockModel& clock() const override { return clock_; }

 private:
  /// A received packet that has valid columns, and the places of these in the grid, the first
  /// decoded packet's turn being 0.
  struct ReceivedPacket {
    std::vector<uint8_t> bytes;
    Packet packet;                 ///< its columns point into `bytes`
    uint16_t first = 0, last = 0;  ///< the first and last valid column
    Stamp stamp;                   ///< host time of the first
    bool after_restart = false;
    uint32_t refused_before = 0;  ///< packets refused since the packet before it
  };

  bool read(const Datagram& datagram);
  void stamp_packet(const lidar::ArrivalOrder::Verdict& verdict, Stamp host);
  void begin_decoding();
  int64_t turn_of_held();
  int64_t packets_of(int64_t columns) const;
  void detect_loss();
  bool decode(Sweep& sweep);
  uint16_t end_of_run(uint16_t first, int64_t sweep) const;
  void close();

  PacketLayout layout_;
  TurnGrid grid_;
  double turns_per_second_;
  Duration max_span_;
  lidar::PacketCounters& counters_;
  lidar::Losses& losses_;
  ClockModel clock_;
  lidar::ArrivalOrder order_;
  TurnWriter writer_;
  uint64_t sweeps_ = 0;
  uint32_t refused_ = 0;  ///< packets refused since the newest

  std::array<ReceivedPacket, 2> received_;
  ReceivedPacket* held_ = &received_[0];  ///< the packet being decoded; waits for the following one
  ReceivedPacket* following_ = &received_[1];
  bool has_held_ = false;
  bool has_following_ = false;
  bool decoding_ = false;
  bool finished_ = false;

  // Of the held packet, while it is decoded.
  std::array<int64_t, kMaxColumnsPerPacket> places_{};  ///< of valid columns
  uint16_t next_column_ = 0;
  uint32_t lost_before_ = 0;

  // Of the last decoded packet.
  bool has_last_ = false;
  uint32_t last_frame_ = 0;  ///< of its first column
  int64_t last_turn_ = 0;    ///< of that frame
  int64_t next_place_ = 0;   ///< behind its columns, valid or not
  int64_t last_device_ns_ = 0;
  int64_t open_sweep_ = 0;  ///< number by the grid of the open sweep
};

}  // namespace infuse::ouster

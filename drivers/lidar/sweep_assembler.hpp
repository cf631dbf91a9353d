#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/lidar/arrival_order.hpp"
#include "drivers/lidar/decoder_options.hpp"
#include "drivers/lidar/firing_plan.hpp"
#include "drivers/lidar/losses.hpp"
#include "drivers/lidar/packet_assembler.hpp"
#include "drivers/lidar/packet_counters.hpp"
#include "drivers/lidar/packet_header.hpp"
#include "drivers/lidar/sweep_cutter.hpp"
#include "drivers/lidar/sweep_writer.hpp"
#include "drivers/measurement/clock_model.hpp"
#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/sweep.hpp"

namespace infuse::lidar {

/// Reads the returns of a maker's data packets.
class ReturnReader {
 public:
  /// Appends sequences `first` … `last` − 1 of a packet to the open sweep; at least one.
  virtual void append(const HeldPacket& packet, const FiringPlan& plan, size_t first, size_t last,
                      SweepWriter& writer) = 0;

 protected:
  ~ReturnReader() = default;
};

/// Assembles the data packets of one sensor into sweeps, written directly into the caller's
/// `Sweep`: no copy, and no allocation once its arrays have grown to a sweep's size. It orders
/// packets, relates the device's clock to the host's, finds what is missing, repairs stray azimuths
/// and cuts sweeps; a `ReturnReader` reads the returns.
///
/// A packet is decoded when the next one has arrived, since only that contains the azimuth of its
/// last returns (and the time after a jump). The assembler is therefore one packet (0.06 … 1.4 ms)
/// behind.
///
/// A sweep runs from the cut azimuth to the cut azimuth, by the azimuth of sequences; if the sensor
/// scans a part of the turn only, from the beginning of that part to its end.
class SweepAssembler final : public PacketAssembler {
 public:
  /// The options must be valid. Counts into `counters` and `losses`, and reads returns with
  /// `reader`, which must outlive this object.
  SweepAssembler(const DecoderOptions& options, const ClockModelOptions& clock,
                 const SequenceTiming& timing, ReturnReader& reader, PacketCounters& counters,
                 Losses& losses);

  void set_timing(const SequenceTiming& timing) override { timing_ = timing; }
  std::optional<ArrivalOrder::Verdict> push(const Datagram& datagram,
                                            const PacketHeader& header) override;
  void note_refused() override {
    require_pulled();
    ++refused_;
  }
  void require_pulled() const override;
  bool pull(Sweep& sweep) override;
  void finish() override { finished_ = true; }
  void resume() override { finished_ = false; }
  ClockModel& clock() override { return clock_; }
  const ClockModel& clock() const override { return clock_; }

 private:
  /// A received packet.
  struct ReceivedPacket {
    std::vector<uint8_t> bytes;
    PacketHeader header;
    int64_t device_ns = 0;  ///< of the counter, unwrapped
    Stamp stamp;            ///< host time of the counter
    bool after_clock_jump = false;
    uint32_t refused_before = 0;  ///< packets refused since the packet before it
  };
  /// Known data of the last decoded packet.
  struct LastDecoded {
    bool valid = false;
    int azimuth = 0;     ///< 0.01°, of its last sequence
    int step = 0;        ///< 0.01°, of its last sequence
    int64_t end_ns = 0;  ///< device time of the sequence after its last
    std::optional<uint32_t> number;
  };

  void stamp_packet(const ArrivalOrder::Verdict& verdict, Stamp host);
  void begin_decoding(const ReceivedPacket* following);
  void repair_held_azimuths(const ReceivedPacket* following);
  void plan_cuts();
  int64_t count_missing(int64_t gap_ns, int64_t pause_ns) const;
  void detect_gap(PlannedSequence& first);
  bool decode(Sweep& sweep);
  void close();

  uint16_t beams_;
  Duration max_span_;
  SequenceTiming timing_;
  ReturnReader& reader_;
  PacketCounters& counters_;
  Losses& losses_;
  ClockModel clock_;
  ArrivalOrder order_;
  SweepCutter cutter_;
  RotationRate rotation_;
  SweepWriter writer_;
  uint64_t sweeps_ = 0;
  int64_t newest_device_ns_ = 0;  ///< of the newest packet, unwrapped
  uint32_t refused_ = 0;          ///< packets refused since the newest

  std::array<ReceivedPacket, 2> received_;
  ReceivedPacket* held_ = &received_[0];  ///< the packet being decoded; waits for the following one
  ReceivedPacket* following_ = &received_[1];
  bool has_held_ = false;
  bool has_following_ = false;
  bool decoding_ = false;
  bool finished_ = false;

  FiringPlan plan_;
  std::array<bool, kMaxSequences> cut_before_{};
  size_t next_sequence_ = 0;
  std::optional<int> gap_from_;  ///< 0.01°, set if packets are missing before the held one
  uint32_t lost_before_first_ = 0;
  LastDecoded last_decoded_;
};

}  // namespace infuse::lidar

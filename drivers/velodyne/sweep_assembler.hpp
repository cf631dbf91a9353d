#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/measurement/clock_model.hpp"
#include "drivers/measurement/datagram.hpp"
#include "drivers/measurement/sweep.hpp"
#include "drivers/velodyne/arrival_order.hpp"
#include "drivers/velodyne/beam_table.hpp"
#include "drivers/velodyne/calibration.hpp"
#include "drivers/velodyne/calibration_stream.hpp"
#include "drivers/velodyne/firing_cycle_estimator.hpp"
#include "drivers/velodyne/firing_plan.hpp"
#include "drivers/velodyne/model.hpp"
#include "drivers/velodyne/packet_counters.hpp"
#include "drivers/velodyne/sweep_cutter.hpp"
#include "drivers/velodyne/sweep_writer.hpp"

namespace infuse::velodyne {

/// Where the calibration of a sensor comes from.
enum class CalibrationSource : uint8_t {
  kBuiltIn,  ///< the same for all units, or an example (HDL-64E, until its stream has told it)
  kFile,     ///< by file
  kStream,   ///< by the sensor itself (HDL-64E)
};

/// What a `SweepAssembler` is told.
struct SweepAssemblerOptions {
  Model model = Model::kHdl32e;
  std::optional<Calibration> calibration{};  ///< of this unit; the model's own where absent
  double cut_azimuth = 0;  ///< °, as the sensor counts it (clockwise from the vendor's y, which
                           ///< is forward): where a sweep ends and the next begins, 0 … 360
  bool interpolate_azimuth = true;  ///< false: every return has its block's azimuth, as simple
                                    ///< viewers show it; wrong by up to 0.2°
  uint32_t sender = 0;  ///< IPv4 address of the sensor, host byte order; 0: whoever speaks first
  Duration max_span{400'000'000};  ///< ns: a sweep that lasts longer is ended (a sensor that does
                                   ///< not turn)

  InstructionSet instruction_set = best_instruction_set();  ///< all give the same bytes

  /// What is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;
};

/// Turns the data packets of one sensor into sweeps, written straight into the `Sweep` that the
/// caller hands it: no copy, and no allocation once its arrays have grown to a sweep's size.
///
/// A packet is decoded when the next one has come, since only that tells the azimuth of its last
/// returns (and the time after a jump); so the assembler is one packet (0.06 … 1.4 ms) behind.
///
///     assembler.push(datagram);
///     while (assembler.pull(*sweep)) sweep = publish_and_take_an_empty_one(sweep);
///
/// A sweep runs from the cut azimuth to the cut azimuth, by the azimuth of blocks; where the sensor
/// looks at a part of the turn only, from that part's beginning to its end instead.
class SweepAssembler {
 public:
  /// The options must be valid.
  explicit SweepAssembler(const SweepAssemblerOptions& options);

  /// Takes a datagram of the data port. Whatever it holds: it is used, or counted with the reason.
  /// `pull` must have said false since the last push.
  void push(const Datagram& datagram);

  /// Decodes on into `sweep`. True: the sweep is complete, call again with an empty one. False: all
  /// that can be decoded is in; hand the same sweep in again after the next push.
  bool pull(Sweep& sweep);

  /// The stream has ended: `pull` until false gives what is left.
  void finish();

  /// What became of every datagram.
  const PacketCounters& counters() const { return counters_; }

  /// Tells of datagrams that the kernel dropped before they came here.
  void add_kernel_dropped(uint64_t datagrams) { counters_.kernel_dropped += datagrams; }

  /// How the device's clock relates to the host's, as of the last packet.
  const ClockState& clock() const { return clock_.state(); }

  /// The host's time of a device counter that lies within half an hour of the last packet's: for
  /// position packets.
  Stamp to_host(uint32_t counter_us) const {
    return clock_.to_host(std::chrono::microseconds(counter_us));
  }

  /// Where the calibration in use comes from.
  CalibrationSource calibration_source() const { return calibration_source_; }

  /// The firing cycle in use: the model's, or as observed where firmware decides it.
  Duration firing_cycle() const { return table_.cycle; }

 private:
  /// A packet that has come.
  struct ReceivedPacket {
    std::array<uint8_t, kPacketSize> bytes{};
    Packet packet;
    int64_t device_ns = 0;  ///< of the counter, unwrapped
    Stamp stamp;            ///< host's time of the counter
    bool after_clock_jump = false;
  };
  /// What is known of the last packet that was decoded.
  struct LastDecoded {
    bool valid = false;
    int azimuth = 0;     ///< 0.01°, of its last sequence
    int step = 0;        ///< 0.01°, of its last sequence
    int64_t end_ns = 0;  ///< device time when the sequence after its last would start
  };

  bool accept(const Datagram& datagram);
  void order_packet(const Datagram& datagram, const Packet& packet);
  void update_beam_table(const Packet& packet, const ArrivalOrder::Verdict& verdict);
  void begin_decoding(const ReceivedPacket* following);
  void detect_gap(PlannedSequence& first);
  bool decode(Sweep& sweep);
  void close();

  SweepAssemblerOptions options_;
  const ModelInfo& info_;
  PacketCounters counters_;
  CalibrationSource calibration_source_;
  Calibration calibration_;
  BeamTable table_;
  CalibrationStream calibration_stream_;
  FiringCycleEstimator cycle_estimator_;
  ClockModel clock_;
  ArrivalOrder order_;
  SweepCutter cutter_;
  SweepWriter writer_;
  uint32_t sender_ = 0;
  uint64_t sweeps_ = 0;
  int64_t newest_device_ns_ = 0;  ///< of the newest packet, unwrapped

  std::array<ReceivedPacket, 2> received_;
  ReceivedPacket* held_ = &received_[0];  ///< waits for what follows it; being decoded
  ReceivedPacket* following_ = &received_[1];
  bool has_held_ = false;
  bool has_following_ = false;
  bool decoding_ = false;
  bool finished_ = false;

  FiringPlan plan_;
  std::array<bool, kBlocks> cut_before_{};
  size_t next_sequence_ = 0;
  std::optional<int> gap_from_;  ///< 0.01°, where packets are missing before the held one
  uint32_t lost_before_first_ = 0;
  LastDecoded last_decoded_;
};

}  // namespace infuse::velodyne

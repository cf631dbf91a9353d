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
#include "drivers/velodyne/sender_lock.hpp"
#include "drivers/velodyne/sweep_cutter.hpp"
#include "drivers/velodyne/sweep_writer.hpp"

namespace infuse::velodyne {

/// Origin of a sensor's calibration.
enum class CalibrationSource : uint8_t {
  kBuiltIn,  ///< identical for all units, or an example (HDL-64E, until its stream has been read)
  kFile,     ///< from a file
  kStream,   ///< from the sensor itself (HDL-64E)
};

/// Options of a `SweepAssembler`.
struct SweepAssemblerOptions {
  Model model = Model::kHdl32e;
  std::optional<Calibration> calibration{};  ///< of this unit; the model's own if absent
  double cut_azimuth =
      0;  ///< °, as the sensor counts it (clockwise from the vendor's y, which is
          ///< forward): azimuth at which a sweep ends and the next begins, −360 … 360
  bool interpolate_azimuth = true;  ///< false: every return has its block's azimuth, as in simple
                                    ///< viewers; wrong by up to 0.2°
  uint32_t sender = 0;  ///< IPv4 address of the sensor, host byte order; 0: see `SenderLock`
  /// Maximum duration of a sweep, ns (for a sensor that does not turn).
  Duration max_span{400'000'000};

  InstructionSet instruction_set = best_instruction_set();  ///< all give the same bytes

  /// Returns what is wrong with the numbers, or nothing.
  std::optional<std::string> invalid() const;
};

/// Assembles the data packets of one sensor into sweeps, written directly into the caller's
/// `Sweep`: no copy, and no allocation once its arrays have grown to a sweep's size.
///
/// A packet is decoded when the next one has arrived, since only that contains the azimuth of its
/// last returns (and the time after a jump). The assembler is therefore one packet (0.06 … 1.4 ms)
/// behind.
///
///     assembler.push(datagram);
///     while (assembler.pull(*sweep)) sweep = publish_and_claim_an_empty_one(sweep);
///
/// A sweep runs from the cut azimuth to the cut azimuth, by the azimuth of blocks; if the sensor
/// scans a part of the turn only, from the beginning of that part to its end.
class SweepAssembler {
 public:
  /// The options must be valid.
  explicit SweepAssembler(const SweepAssemblerOptions& options);

  /// Adds a datagram of the data port. It is used, or counted with the reason. `pull` must have
  /// returned false since the last push.
  void push(const Datagram& datagram);

  /// Decodes into `sweep`. True: the sweep is complete, call again with an empty one. False: all
  /// available data is decoded; pass the same sweep again after the next push.
  bool pull(Sweep& sweep);

  /// Ends the stream: `pull` until false returns the remaining data.
  void finish();

  /// Number of datagrams by outcome.
  const PacketCounters& counters() const { return counters_; }

  /// From which address the sensor sends.
  const SenderLock& sender() const { return sender_; }

  /// Adds datagrams that the kernel dropped before they arrived here.
  void add_kernel_dropped(uint64_t datagrams) { counters_.kernel_dropped += datagrams; }

  /// State of the device's clock at the last packet.
  const ClockState& clock() const { return clock_.state(); }

  /// States that an NMEA sentence agrees with the device's counter: it runs from the top of the
  /// hour, even if the host's clock says otherwise.
  void confirm_hour() { clock_.confirm_hour(); }

  /// Host time of a device counter within half an hour of the last packet's: for position packets.
  Stamp to_host(uint32_t counter_us) const {
    return clock_.to_host(std::chrono::microseconds(counter_us));
  }

  /// The calibration in use.
  const Calibration& calibration() const { return calibration_; }

  /// Origin of the calibration in use.
  CalibrationSource calibration_source() const { return calibration_source_; }

  /// Firing cycle in use: the model's, or the observed one if firmware determines it.
  Duration firing_cycle() const { return table_.cycle; }

 private:
  /// A received packet.
  struct ReceivedPacket {
    std::array<uint8_t, kPacketSize> bytes{};
    Packet packet;
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
  };

  bool accept(const Datagram& datagram);
  void forget_unit();
  void order_packet(const Datagram& datagram, const Packet& packet);
  void update_beam_table(const Packet& packet, const ArrivalOrder::Verdict& verdict);
  void begin_decoding(const ReceivedPacket* following);
  void repair_held_azimuths(const ReceivedPacket* following, int64_t period_ns);
  void detect_gap(PlannedSequence& first, int64_t period_ns);
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
  RotationRate rotation_;
  SweepWriter writer_;
  SenderLock sender_;
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
  std::array<bool, kBlocks> cut_before_{};
  size_t next_sequence_ = 0;
  std::optional<int> gap_from_;  ///< 0.01°, set if packets are missing before the held one
  uint32_t lost_before_first_ = 0;
  LastDecoded last_decoded_;
};

}  // namespace infuse::velodyne

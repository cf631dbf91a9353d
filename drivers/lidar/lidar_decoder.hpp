#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "drivers/lidar/lidar_model.hpp"
#include "drivers/lidar/losses.hpp"
#include "drivers/lidar/model_inference.hpp"
#include "drivers/lidar/packet_counters.hpp"
#include "drivers/lidar/sender_lock.hpp"
#include "drivers/lidar/sweep_assembler.hpp"
#include "drivers/measurement/gyro_readings.hpp"
#include "drivers/measurement/vehicle_samples.hpp"

namespace infuse::lidar {

/// Decodes the datagrams of one sensor, of all its ports, into sweeps and what else they hold.
///
///     decoder.push(datagram);
///     while (decoder.pull(*sweep)) sweep = publish_and_claim_an_empty_one(sweep);
///
/// What all makers share is here: the sender is locked, everything is counted by its cause, the
/// model is compared with what the packets show. A maker's decoder parses packets and reads their
/// returns.
class LidarDecoder : private ReturnReader {
 public:
  LidarDecoder(const LidarDecoder&) = delete;
  LidarDecoder& operator=(const LidarDecoder&) = delete;
  virtual ~LidarDecoder();

  /// Adds a datagram. It is used, or counted with the reason. After a data packet, `pull` of a
  /// sweep must return false before the next one; samples not pulled are lost.
  void push(const Datagram& datagram);

  /// Decodes into `sweep`. True: the sweep is complete, call again with an empty one. False: all
  /// available data is decoded; pass the same sweep again after the next push.
  bool pull(Sweep& sweep) { return assembler_->pull(sweep); }

  /// The new fix of a GNSS receiver, readings of the gyros or sample of the inertial unit in the
  /// last datagram. False if there is none; the argument is unchanged then.
  bool pull(GnssFix& fix) { return take(fix_, fix); }
  bool pull(GyroReadings& readings) { return take(gyros_, readings); }  ///< as for a fix
  bool pull(ImuSample& sample) { return take(imu_, sample); }           ///< as for a fix

  /// Ends the stream: `pull` until false returns the remaining data.
  void finish();

  /// Number of datagrams by outcome, and what the packets show of the sensor.
  const PacketCounters& counters() const { return counters_; }

  /// State of the device's clock at the last packet.
  const ClockState& clock() const { return assembler_->clock().state(); }

  /// Host time of a device counter within half a wrap of the last packet's.
  Stamp to_host(Duration counter) const { return assembler_->clock().to_host(counter); }

  /// The configured model.
  const LidarModel& model() const { return model_; }

  /// Origin of the calibration in use.
  CalibrationSource calibration_source() const { return calibration_source_; }

  /// True while the sensor is decoded with another unit's calibration.
  bool is_uncalibrated() const {
    return model_.calibrated_per_unit && calibration_source_ == CalibrationSource::kBuiltIn;
  }

  /// The calibration that the sensor itself has sent; null if it has not.
  virtual std::shared_ptr<const UnitCalibration> streamed_calibration() const { return nullptr; }

  /// Counts datagrams that the kernel dropped: see `Losses`.
  void add_kernel_dropped(uint64_t datagrams, bool data) {
    losses_.add_kernel_dropped(datagrams, data);
  }
  /// Counts datagrams that a filter has left out.
  void add_filtered(uint64_t datagrams) { losses_.add_filtered(datagrams); }

 protected:
  /// Assembles by azimuth. The options must be valid; `timing` is that of the model's sequences.
  LidarDecoder(const DecoderOptions& options, const ClockModelOptions& clock,
               const SequenceTiming& timing);

  /// Makes an assembler that counts into these.
  using MakeAssembler =
      std::function<std::unique_ptr<PacketAssembler>(PacketCounters& counters, Losses& losses)>;

  /// Assembles in the maker's own way; `append` is not called. The options must be valid.
  LidarDecoder(const DecoderOptions& options, const MakeAssembler& make_assembler);

  /// Parses the header of a data packet into `header`, which is empty. Returns what is wrong with
  /// the payload as static text, or null. All of the payload that `append` reads must be checked.
  virtual const char* parse(std::span<const uint8_t> payload, PacketHeader& header) const = 0;

  /// Puts the returns of a packet into a sweep.
  void append(const HeldPacket&, const FiringPlan&, size_t, size_t, SweepWriter&) override {}

  /// Reads an information packet, or a packet of the inertial unit, of the sensor itself. Returns
  /// what is wrong with it as static text, or null.
  virtual const char* read_information(const Datagram& datagram);
  virtual const char* read_inertial(const Datagram& datagram);  ///< of the inertial unit

  /// Takes note of a data packet that will be decoded.
  virtual void observe(std::span<const uint8_t>, const PacketHeader&,
                       const ArrivalOrder::Verdict&) {}

  /// Forgets what packets have shown of the unit: another one sends from now on.
  virtual void forget_unit() {}

  /// Hands on what a packet holds.
  void give(const GnssFix& fix) { fix_ = fix; }
  void give(const GyroReadings& readings) { gyros_ = readings; }  ///< to `pull`
  void give(const ImuSample& sample) { imu_ = sample; }           ///< to `pull`

  /// Sets where the beams' angles are from.
  void set_calibration_source(CalibrationSource source) { calibration_source_ = source; }
  /// Sets when the beams of a firing fire.
  void set_timing(const SequenceTiming& timing) { assembler_->set_timing(timing); }

  /// States that the device's counter agrees with UTC, even if the host's clock says otherwise.
  void confirm_hour() { assembler_->clock().confirm_hour(); }

 private:
  template <class T>
  static bool take(std::optional<T>& from, T& to) {
    if (!from) return false;
    to = *std::exchange(from, std::nullopt);
    return true;
  }

  void push_data(const Datagram& datagram, bool data_packet);
  bool accept(const Datagram& datagram);
  void push_other(const Datagram& datagram, bool inertial);
  void refuse(const Datagram& datagram, const char* reason);
  void reject_sender(const Datagram& datagram);
  void compare_model();

  const LidarModel& model_;
  PacketCounters counters_;
  Losses losses_{counters_};
  SenderLock sender_;
  std::unique_ptr<PacketAssembler> assembler_;
  std::unique_ptr<ModelInference> inference_;
  uint64_t compared_packets_ = 0;
  CalibrationSource calibration_source_;
  std::optional<GnssFix> fix_;
  std::optional<GyroReadings> gyros_;
  std::optional<ImuSample> imu_;
};

}  // namespace infuse::lidar

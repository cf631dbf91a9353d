#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "drivers/lidar/lidar_decoder.hpp"
#include "drivers/robosense/beam_table.hpp"
#include "drivers/robosense/info_packet.hpp"
#include "drivers/robosense/packet.hpp"
#include "drivers/robosense/return_kernel.hpp"

namespace infuse::robosense {

/// Decodes the packets of one RoboSense lidar. The unit's own angles and its return mode are read
/// from its information packets; until one has been seen, the angles are the model's.
class Decoder final : public lidar::LidarDecoder {
 public:
  /// The options must be valid; model and calibration must be of this maker.
  explicit Decoder(const lidar::DecoderOptions& options);

  /// The calibration in use.
  const Calibration& calibration() const { return table_.calibration(); }

  std::shared_ptr<const lidar::UnitCalibration> streamed_calibration() const override;

 private:
  const char* parse(std::span<const uint8_t> payload, lidar::PacketHeader& header) const override;
  const char* read_information(const Datagram& datagram) override;
  void observe(std::span<const uint8_t> payload, const lidar::PacketHeader& header,
               const lidar::ArrivalOrder::Verdict& verdict) override;
  void forget_unit() override;
  void append(const lidar::HeldPacket& packet, const lidar::FiringPlan& plan, size_t first,
              size_t last, lidar::SweepWriter& writer) override;

  bool is_16p() const { return info_.model == Model::kHelios16p; }
  bool is_bpearl() const { return info_.model >= Model::kBpearl; }
  ReturnMode mode_of(bool dual) const;
  void set_dual(bool dual);
  void use(const gnss::NmeaFix& sentence, Stamp stamp);

  const ModelInfo& info_;
  BeamTable table_;
  ReturnKernel kernel_;
  bool interpolate_;
  std::optional<ReturnMode> mode_;  ///< as the sensor has stated
  std::optional<uint32_t> newest_number_;
  int64_t newest_ns_ = 0;            ///< device time of the newest data packet
  int64_t last_sentence_ns_ = 0;     ///< UTC of the latest sentence
  uint64_t agreeing_sentences_ = 0;  ///< sentences in a row that agree with the device's clock
};

}  // namespace infuse::robosense

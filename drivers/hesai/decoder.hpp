#pragma once

#include <cstdint>

#include "drivers/hesai/beam_table.hpp"
#include "drivers/hesai/packet.hpp"
#include "drivers/hesai/return_kernel.hpp"
#include "drivers/lidar/lidar_decoder.hpp"

namespace infuse::hesai {

/// Decodes the packets of one Hesai lidar.
class Decoder final : public lidar::LidarDecoder {
 public:
  /// The options must be valid; model and calibration must be of this maker.
  explicit Decoder(const lidar::DecoderOptions& options);

 private:
  const char* parse(std::span<const uint8_t> payload, lidar::PacketHeader& header) const override;
  const char* read_information(const Datagram& datagram) override;
  void observe(std::span<const uint8_t> payload, const lidar::PacketHeader& header,
               const lidar::ArrivalOrder::Verdict& verdict) override;
  void append(const lidar::HeldPacket& packet, const lidar::FiringPlan& plan, size_t first,
              size_t last, lidar::SweepWriter& writer) override;

  const ModelInfo& info_;
  BeamTable table_;
  ReturnKernel kernel_;
  bool interpolate_;
  int64_t newest_utc_ns_ = 0;        ///< device time of the newest data packet
  int64_t last_sentence_ns_ = 0;     ///< UTC of the latest sentence
  uint64_t agreeing_sentences_ = 0;  ///< sentences in a row that agree with the device's clock
};

}  // namespace infuse::hesai

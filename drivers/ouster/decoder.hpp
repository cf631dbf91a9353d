#pragma once

#include <memory>
#include <string_view>

#include "drivers/lidar/lidar_decoder.hpp"
#include "drivers/ouster/metadata.hpp"
#include "drivers/ouster/ouster_maker.hpp"
#include "drivers/ouster/packet.hpp"

namespace infuse::ouster {

/// A unit's calibration: its metadata.
struct UnitCalibration final : lidar::UnitCalibration {
  explicit UnitCalibration(const Metadata& unit)
      : lidar::UnitCalibration(model_of(unit)), metadata(unit) {}
  std::string_view text() const override { return metadata.text; }
  const Metadata metadata;
};

/// Decodes the packets of one Ouster: lidar packets to sweeps, inertial packets to samples in the
/// lidar frame.
class Decoder final : public lidar::LidarDecoder {
 public:
  /// The options must be valid, with a calibration of this maker.
  explicit Decoder(const lidar::DecoderOptions& options);

 private:
  const char* parse(std::span<const uint8_t> payload, lidar::PacketHeader& header) const override;
  const char* read_inertial(const Datagram& datagram) override;

  std::shared_ptr<const lidar::UnitCalibration> calibration_;
  const Metadata& metadata_;  ///< of the calibration
  PacketLayout layout_;
};

}  // namespace infuse::ouster

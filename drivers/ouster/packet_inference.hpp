#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/lidar/model_inference.hpp"
#include "drivers/ouster/metadata.hpp"

namespace infuse::ouster {

/// What lidar packets show of a sensor without its metadata: that it is an Ouster, and how fast it
/// turns. They state no model.
class PacketInference final : public lidar::ModelInference {
 public:
  void add(std::span<const uint8_t> payload) override;
  const lidar::LidarModel* judge() const override { return nullptr; }
  std::optional<lidar::InferredModel> infer() const override { return std::nullopt; }
  std::string describe() const override;
  uint64_t packets() const override { return packets_; }
  uint64_t min_packets() const override { return 1; }
  double turns_per_second() const override;
  bool has_two_sensors() const override;

  /// True if the packets are those of a sensor with this metadata: their layout, and the serial
  /// number where both state one.
  bool fits(const Metadata& metadata) const;

 private:
  uint64_t packets_ = 0;
  std::vector<uint8_t> first_;  ///< payload of the first packet
  uint64_t serial_number_ = 0;  ///< of the latest packet that states one
  uint64_t other_serial_numbers_ = 0;
  bool started_ = false;
  int64_t last_ns_ = 0;
  uint32_t last_frame_ = 0;
  uint64_t backwards_ = 0;  ///< packets before their predecessor
  int64_t turns_ = 0;
  int64_t turns_begin_ns_ = 0, turns_end_ns_ = 0;  ///< device times of the first and latest turn
};

}  // namespace infuse::ouster

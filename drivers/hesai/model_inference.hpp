#pragma once

#include <array>
#include <cstdint>

#include "drivers/hesai/packet.hpp"
#include "drivers/lidar/model_inference.hpp"
#include "drivers/lidar/packet_tracks.hpp"

namespace infuse::hesai {

/// Infers the model of a Hesai lidar from what its data packets state.
class ModelInference final : public lidar::ModelInference {
 public:
  void add(std::span<const uint8_t> payload) override;
  const lidar::LidarModel* judge() const override;
  std::optional<lidar::InferredModel> infer() const override;
  std::string describe() const override;
  uint64_t packets() const override { return packets_; }
  uint64_t min_packets() const override;
  double turns_per_second() const override;
  bool has_two_sensors() const override { return tracks_.alternate(); }

 private:
  void parse(const ModelInfo& info, std::span<const uint8_t> payload);
  const ModelInfo* judge_info() const;

  uint64_t packets_ = 0;
  std::array<uint64_t, 7> of_model_{};  ///< packets of each model
  Packet last_;                         ///< latest that was parsed
  size_t last_size_ = 0;                ///< its bytes
  std::array<uint8_t, 2> version_{};    ///< of its header; 0: none
  lidar::PacketTracks tracks_{Duration(0)};
  int64_t turned_ = 0;      ///< 0.01°
  int64_t turning_us_ = 0;  ///< time in which the sensor turned by it
};

}  // namespace infuse::hesai

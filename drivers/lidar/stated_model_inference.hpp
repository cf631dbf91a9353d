#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/lidar/lidar_model.hpp"
#include "drivers/lidar/model_inference.hpp"
#include "drivers/lidar/packet_tracks.hpp"

namespace infuse::lidar {

/// Infers the model of a sensor whose packets state it, by majority: see `LidarMaker::read_stated`.
class StatedModelInference final : public ModelInference {
 public:
  explicit StatedModelInference(const LidarMaker& maker);

  void add(std::span<const uint8_t> payload) override;
  const LidarModel* judge() const override;
  std::optional<InferredModel> infer() const override;
  std::string describe() const override;
  uint64_t packets() const override { return packets_; }
  uint64_t min_packets() const override { return 20; }
  double turns_per_second() const override;
  bool has_two_sensors() const override { return tracks_.alternate(); }

 private:
  struct Votes {
    const LidarModel* model = nullptr;
    uint64_t packets = 0;
  };

  const LidarMaker& maker_;
  PacketTracks tracks_{Duration(0)};
  std::array<Votes, 8> votes_{};  ///< models beyond these do not count
  std::vector<uint8_t> latest_;   ///< payload of the latest packet that was read
  uint64_t packets_ = 0;
  int64_t turned_ = 0;      ///< 0.01°
  int64_t turning_us_ = 0;  ///< time in which the sensor turned by it
};

}  // namespace infuse::lidar

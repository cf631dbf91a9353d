#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/lidar/lidar_model.hpp"
#include "drivers/lidar/model_inference.hpp"
#include "drivers/lidar/packet_tracks.hpp"

namespace infuse::lidar {

/// Infers the model of a sensor whose packets state it, by majority.
class StatedModelInference final : public ModelInference {
 public:
  /// What a data packet states.
  struct Packet {
    const LidarModel* model = nullptr;  ///< null: one that is not known
    Duration counter{0};                ///< device time of the first firing
    int azimuth = 0;                    ///< 0.01°, of the first firing
  };
  /// Reads a payload; nothing if it is not a data packet.
  using Reader = std::optional<Packet> (*)(std::span<const uint8_t> payload);

  /// `modulo`: time after which the device's counter wraps; 0: never.
  StatedModelInference(Reader reader, Duration modulo) : reader_(reader), tracks_(modulo) {}

  void add(std::span<const uint8_t> payload) override;
  const LidarModel* judge() const override;
  std::optional<InferredModel> infer() const override;
  std::string describe() const override;
  uint64_t packets() const override { return packets_; }
  uint64_t min_packets() const override { return 8; }
  double turns_per_second() const override;
  bool has_two_sensors() const override { return tracks_.alternate(); }

 private:
  struct Votes {
    const LidarModel* model = nullptr;
    uint64_t packets = 0;
  };

  Reader reader_;
  PacketTracks tracks_;
  std::array<Votes, 8> votes_{};  // models beyond these do not count
  uint64_t packets_ = 0;
  int64_t turned_ = 0;      // 0.01°, of all packets that follow directly
  int64_t turning_us_ = 0;  // time of these
};

}  // namespace infuse::lidar

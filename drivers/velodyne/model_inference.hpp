#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/lidar/model_inference.hpp"
#include "drivers/lidar/packet_tracks.hpp"
#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {

/// Infers the model of a sensor from its packets, by majority: the flags of blocks, the period of
/// packets, repeated azimuths (two returns), and the product byte (which is wrong on early VLP-16
/// firmware, and missing on an HDL-64E). Allocates nothing but the reason.
class ModelInference final : public lidar::ModelInference {
 public:
  /// Number of packets from which a model is inferred.
  static constexpr uint64_t kMinPackets = 8;

  void add(std::span<const uint8_t> payload) override;
  std::optional<lidar::InferredModel> infer() const override;
  std::string describe() const override;

  const lidar::LidarModel* judge() const override;
  double turns_per_second() const override;
  uint64_t packets() const override { return packets_; }
  uint64_t min_packets() const override { return kMinPackets; }
  bool has_two_sensors() const override;

 private:
  /// Layout of a packet's blocks.
  enum class Layout : uint8_t { kOneBank, kTwoBanks, kFourBanks };

  const ModelInfo* judge_info() const;
  static Layout layout_of(std::span<const uint8_t> payload);
  Layout layout() const;
  bool dual() const;
  uint8_t product_id() const;
  int64_t median_period_us() const;
  std::string spacing() const;

  static constexpr size_t kMaxPeriods = 63;
  lidar::PacketTracks tracks_{std::chrono::microseconds(kHourUs)};
  std::array<int64_t, kMaxPeriods> periods_us_{};  ///< the latest
  uint64_t periods_ = 0;
  uint64_t packets_ = 0;
  int64_t turned_ = 0;                       ///< 0.01°, of all packets that follow directly
  int64_t turning_us_ = 0;                   ///< time of these
  std::array<uint64_t, 3> layouts_{};        ///< packets by `Layout`
  std::array<uint32_t, 256> product_ids_{};  ///< packets by product byte
  uint64_t repeated_ = 0;                    ///< packets whose blocks come in pairs of one azimuth
  uint64_t unrepeated_ = 0;
  uint64_t dual_mode_ = 0;  ///< packets whose return mode says two returns
};

}  // namespace infuse::velodyne

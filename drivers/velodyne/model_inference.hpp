#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/velodyne/model.hpp"
#include "drivers/velodyne/packet_tracks.hpp"

namespace infuse::velodyne {

/// A model and the reason for it.
struct InferredModel {
  Model model = Model::kHdl32e;
  std::string reason;  ///< "packets 1327 us apart are a VLP-16's, though product byte 0x21 says …"
};

/// Infers the model of a sensor from its packets, by majority: the flags of blocks, the period of
/// packets, repeated azimuths (two returns), and the product byte (which is wrong on early VLP-16
/// firmware, and missing on an HDL-64E). Allocates nothing but the reason.
class ModelInference {
 public:
  /// Number of packets from which a model is inferred.
  static constexpr uint64_t kMinPackets = 8;

  /// Adds the payload of a packet of the data port; other payloads are ignored.
  void add(std::span<const uint8_t> payload);

  /// Nothing while fewer than 8 packets have been seen, or if no model fits them.
  std::optional<InferredModel> infer() const;

  /// What is known of the packets: "product byte 0x99, packets 553 us apart".
  std::string describe() const;

  /// The same as `infer` without the reason.
  std::optional<Model> judge() const;

  /// Turns per second by azimuth over the device's time, whatever the model; 0 while unknown.
  double turns_per_second() const;

  /// Number of data packets seen.
  uint64_t packets() const { return packets_; }

  /// True if packets of two sensors alternate.
  bool has_two_sensors() const;

 private:
  /// Layout of a packet's blocks.
  enum class Layout : uint8_t { kOneBank, kTwoBanks, kFourBanks };

  static Layout layout_of(std::span<const uint8_t> payload);
  Layout layout() const;
  bool dual() const;
  uint8_t product_id() const;
  int64_t median_period_us() const;
  std::string spacing() const;

  static constexpr size_t kMaxPeriods = 63;
  PacketTracks tracks_;
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

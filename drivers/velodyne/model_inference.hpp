#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/velodyne/model.hpp"

namespace infuse::velodyne {

/// A model and the reason for it.
struct InferredModel {
  Model model = Model::kHdl32e;
  std::string reason;  ///< "product byte 0x21 says HDL-32E, but packets 1327 us apart ... VLP-16"
};

/// Infers the model of a sensor from its packets: the flags of blocks, the product byte, and the
/// period of packets (the product byte is wrong on early VLP-16 firmware, and an HDL-64E has none).
class ModelInference {
 public:
  /// Adds the payload of a packet of the data port; other payloads are ignored.
  void add(std::span<const uint8_t> payload);

  /// Nothing while fewer than 8 packets have been seen, or if no model fits them.
  std::optional<InferredModel> infer() const;

 private:
  static constexpr size_t kMaxPeriods = 63;
  std::array<int64_t, kMaxPeriods> periods_us_{};
  size_t packets_ = 0;
  size_t periods_ = 0;
  uint32_t last_counter_us_ = 0;
  uint16_t second_flag_ = 0;      ///< of the last packet's second block
  bool has_fourth_bank_ = false;  ///< a block of lasers 96 … 127 has been seen
  bool dual_ = false;
  uint8_t product_id_ = 0;
};

}  // namespace infuse::velodyne

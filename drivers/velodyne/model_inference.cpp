#include "drivers/velodyne/model_inference.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {
namespace {

constexpr size_t kMinPackets = 8;
constexpr uint16_t kBank0 = 0xEEFF;
constexpr uint16_t kBank1 = 0xDDFF;
constexpr uint16_t kBank3 = 0xBBFF;

std::string hex(uint8_t byte) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  return {'0', 'x', kDigits[byte >> 4], kDigits[byte & 15]};
}

/// Difference of a period from the model's, relative to the model's.
double relative_period_error(const ModelInfo& info, int64_t period_us, bool dual) {
  const double expected = to_seconds(packet_period(info, info.cycle, dual)) * 1e6;
  return std::abs(static_cast<double>(period_us) / expected - 1);
}

}  // namespace

void ModelInference::add(std::span<const uint8_t> payload) {
  if (payload.size() != kPacketSize || read_u16(payload.data()) != kBank0) return;
  const uint32_t counter_us = read_u32(payload.data() + 1200);
  if (packets_ > 0 && periods_ < kMaxPeriods) {
    const int64_t period = counter_difference_us(counter_us, last_counter_us_);
    if (period > 0) periods_us_[periods_++] = period;
  }
  ++packets_;
  last_counter_us_ = counter_us;
  product_id_ = payload[1205];
  dual_ = payload[1204] == static_cast<uint8_t>(ReturnMode::kDual);
  second_flag_ = read_u16(payload.data() + kBlockSize);
  for (size_t block = 1; block < kBlocks; ++block) {
    has_fourth_bank_ = has_fourth_bank_ || read_u16(payload.data() + block * kBlockSize) == kBank3;
  }
}

std::optional<InferredModel> ModelInference::infer() const {
  if (packets_ < kMinPackets || periods_ == 0) return std::nullopt;
  auto periods = periods_us_;
  auto* middle = periods.data() + periods_ / 2;
  std::nth_element(periods.data(), middle, periods.data() + periods_);
  const int64_t period_us = *middle;
  const std::string spacing = "packets " + std::to_string(period_us) + " us apart";

  if (has_fourth_bank_) return InferredModel{Model::kVls128, "blocks of lasers 96 ... 127"};
  if (second_flag_ == kBank1) {
    const ModelInfo& s2 = model_info(Model::kHdl64eS2);
    const ModelInfo& s3 = model_info(Model::kHdl64eS3);
    const double s3_error = std::min(relative_period_error(s3, period_us, false),
                                     relative_period_error(s3, period_us, true));
    const ModelInfo& better = relative_period_error(s2, period_us, false) < s3_error ? s2 : s3;
    return InferredModel{better.model, "blocks of lasers 32 ... 63, " + spacing};
  }
  for (const ModelInfo& info : models()) {
    if (info.product_id != product_id_ || info.product_id == 0 || info.banks != 1) continue;
    std::string reason = "product byte " + hex(product_id_) + " says " + info.name;
    if (info.model == Model::kHdl32e && relative_period_error(info, period_us, dual_) > 0.1) {
      const ModelInfo& puck = model_info(Model::kVlp16);
      if (relative_period_error(puck, period_us, dual_) < 0.1) {
        reason.append(", but ").append(spacing).append(" are a VLP-16's");
        return InferredModel{Model::kVlp16, reason};
      }
    }
    reason.append(", ").append(spacing);
    return InferredModel{info.model, reason};
  }
  return std::nullopt;
}

}  // namespace infuse::velodyne

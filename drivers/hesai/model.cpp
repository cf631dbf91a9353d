#include "drivers/hesai/model.hpp"

namespace infuse::hesai {
namespace {

// Return mode, motor speed, date, microseconds, factory; size.
constexpr TailLayout kPandarTail{14, 8, 16, 10, 15, 22};
constexpr TailLayout kQt64Tail{16, 10, 18, 12, 17, 24};
constexpr TailLayout kQt128Tail{12, 13, 15, 21, 25, 26};
constexpr TailLayout kXtTail{10, 11, 13, 19, 23, 24};

constexpr std::array<ModelInfo, 7> kHesaiModels{{
    {Model::kPandar40p, "Pandar40P", 40, 10, 0, 0, 4, 3, kPandarTail, Duration(55'560), 2},
    {Model::kPandar64, "Pandar64", 64, 6, 0, 8, 2, 3, kPandarTail, Duration(55'560), 2},
    {Model::kQt64, "QT64", 64, 4, 3, 12, 2, 4, kQt64Tail, Duration(166'667), 2},
    {Model::kQt128, "QT128", 128, 2, 3, 12, 2, 4, kQt128Tail, Duration(111'110), 2},
    {Model::kXt16, "XT16", 16, 8, 6, 12, 2, 4, kXtTail, Duration(50'000), 2},
    {Model::kXt32, "XT32", 32, 8, 6, 12, 2, 4, kXtTail, Duration(50'000), 2},
    {Model::kXt32m, "XT32M", 32, 6, 6, 12, 2, 4, kXtTail, Duration(50'000), 3},
}};

bool has_block_flags(const ModelInfo& info, std::span<const uint8_t> payload) {
  for (size_t block = 0; block < info.blocks; ++block) {
    const uint8_t* flag = payload.data() + block * info.block_size();
    if (flag[0] != 0xFF || flag[1] != 0xEE) return false;
  }
  return true;
}

}  // namespace

bool has_header(const ModelInfo& info, std::span<const uint8_t> payload) {
  if (payload.size() < info.body_end() + info.tail.size) return false;
  if (info.header_size == 0) return has_block_flags(info, payload);
  if (payload[0] != 0xEE || payload[1] != 0xFF) return false;
  if (info.header_size == 8) return payload[2] == info.lasers && payload[3] == info.blocks;
  return payload[2] == info.protocol && payload[6] == info.lasers && payload[7] == info.blocks;
}

const ModelInfo& model_info(Model model) { return kHesaiModels[static_cast<size_t>(model)]; }

std::span<const ModelInfo> models() { return kHesaiModels; }

std::optional<Model> recognise(std::span<const uint8_t> payload) {
  if (payload.empty() || payload[0] < 0xEE) return std::nullopt;  // the first byte of both marks
  for (const ModelInfo& info : kHesaiModels) {
    if (has_header(info, payload)) return info.model;
  }
  return std::nullopt;
}

bool looks_like_hesai(std::span<const uint8_t> payload) {
  constexpr size_t kSmallest = 500;  // below an XT16's packet
  if (payload.size() < kSmallest) return false;
  return (payload[0] == 0xEE && payload[1] == 0xFF) || recognise(payload).has_value();
}

}  // namespace infuse::hesai

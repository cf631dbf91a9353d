#include "drivers/hesai/model_inference.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/hesai/hesai_maker.hpp"
#include "drivers/lidar/azimuth.hpp"

namespace infuse::hesai {
namespace {

constexpr uint64_t kMinPackets = 20;
/// Of so many packets one is parsed; odd, so that two sensors that alternate both are.
constexpr uint64_t kParsedOf = 7;

}  // namespace

void ModelInference::add(std::span<const uint8_t> payload) {
  const auto model = recognise(payload);
  if (!model) return;
  ++of_model_[static_cast<size_t>(*model)];
  if (packets_++ % kParsedOf == 0) parse(model_info(*model), payload);
}

void ModelInference::parse(const ModelInfo& info, std::span<const uint8_t> payload) {
  const auto packet = parse_packet(info, payload);
  if (!packet) return;
  last_ = *packet;
  last_size_ = payload.size();
  version_ = info.protocol != 0 ? std::array{payload[2], payload[3]} : std::array<uint8_t, 2>{};
  if (packet->azimuth[0] == lidar::kNoAzimuth) return;
  const lidar::PacketTracks::Step step = tracks_.add(Duration(packet->utc_ns), packet->azimuth[0]);
  if (step.period_us <= 0) return;
  turned_ += step.advance;
  turning_us_ += step.period_us;
}

uint64_t ModelInference::min_packets() const { return kMinPackets; }

double ModelInference::turns_per_second() const {
  if (turning_us_ <= 0) return 0;
  return static_cast<double>(turned_) * 1e6 /
         (lidar::kCentidegreesPerTurn * static_cast<double>(turning_us_));
}

const ModelInfo* ModelInference::judge_info() const {
  if (packets_ < kMinPackets) return nullptr;
  const auto most = std::max_element(of_model_.begin(), of_model_.end());
  return &model_info(static_cast<Model>(most - of_model_.begin()));
}

const lidar::LidarModel* ModelInference::judge() const {
  const ModelInfo* info = judge_info();
  return info != nullptr ? &lidar_model(info->model) : nullptr;
}

std::optional<lidar::InferredModel> ModelInference::infer() const {
  const ModelInfo* info = judge_info();
  if (info == nullptr) return std::nullopt;
  return lidar::InferredModel{&lidar_model(info->model), describe()};
}

std::string ModelInference::describe() const {
  if (packets_ == 0) return "no data packets";
  std::string text = std::to_string(last_size_) + " bytes";
  if (version_[0] != 0) {
    text.append(", protocol ").append(std::to_string(version_[0])).append(".");
    text.append(std::to_string(version_[1]));
  }
  text.append(", ").append(name_of(last_.mode));
  text.append(last_.returns > 1 ? " returns" : " return");
  const long tenths = std::lround(std::abs(turns_per_second()) * 10);
  text.append(", ").append(std::to_string(tenths / 10)).append(".");
  return text.append(std::to_string(tenths % 10)).append(" turns per second");
}

}  // namespace infuse::hesai

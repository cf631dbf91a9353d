#include "drivers/velodyne/model_inference.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/measurement/median.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

namespace infuse::velodyne {
namespace {

constexpr double kPeriodTolerance = 0.1;
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

bool fits(const ModelInfo& info, int64_t period_us, bool dual) {
  return relative_period_error(info, period_us, dual) < kPeriodTolerance;
}

/// The model of one bank that a product byte names; null if there is none.
const ModelInfo* named_model(uint8_t product_id) {
  for (const ModelInfo& info : models()) {
    if (info.banks == 1 && info.product_id == product_id) return &info;
  }
  return nullptr;
}

/// The first model of one bank with this period of packets, and how many there are.
struct TimedModels {
  const ModelInfo* first = nullptr;
  size_t count = 0;
};
TimedModels timed_models(int64_t period_us, bool dual) {
  TimedModels found;
  for (const ModelInfo& info : models()) {
    if (info.banks > 1 || !fits(info, period_us, dual)) continue;
    if (found.count++ == 0) found.first = &info;
  }
  return found;
}

const ModelInfo& hdl64e(int64_t period_us) {
  const ModelInfo& s2 = model_info(Model::kHdl64eS2);
  const ModelInfo& s3 = model_info(Model::kHdl64eS3);
  const double s3_error = std::min(relative_period_error(s3, period_us, false),
                                   relative_period_error(s3, period_us, true));
  return relative_period_error(s2, period_us, false) < s3_error ? s2 : s3;
}

}  // namespace

void ModelInference::add(std::span<const uint8_t> payload) {
  if (payload.size() != kPacketSize || read_u16(payload.data()) != kBank0) return;
  ++packets_;
  ++layouts_[static_cast<size_t>(layout_of(payload))];
  ++product_ids_[payload[kProductIdOffset]];
  dual_mode_ += payload[kReturnModeOffset] == static_cast<uint8_t>(ReturnMode::kDual);
  const auto azimuth = [&](size_t block) { return read_u16(block_at(payload, block) + 2); };
  if (azimuth(0) != azimuth(2) && azimuth(2) != azimuth(4)) {
    ++(azimuth(0) == azimuth(1) && azimuth(2) == azimuth(3) ? repeated_ : unrepeated_);
  }
  if (azimuth(0) > kCentidegreesPerTurn) return;
  const std::chrono::microseconds counter(read_u32(payload.data() + kCounterOffset));
  const lidar::PacketTracks::Step step = tracks_.add(counter, azimuth(0));
  if (step.period_us <= 0) return;
  periods_us_[periods_++ % kMaxPeriods] = step.period_us;
  turned_ += step.advance;
  turning_us_ += step.period_us;
}

ModelInference::Layout ModelInference::layout_of(std::span<const uint8_t> payload) {
  for (size_t block = 1; block < kBlocks; ++block) {
    if (read_u16(block_at(payload, block)) == kBank3) return Layout::kFourBanks;
  }
  return read_u16(block_at(payload, 1)) == kBank1 ? Layout::kTwoBanks : Layout::kOneBank;
}

ModelInference::Layout ModelInference::layout() const {
  return static_cast<Layout>(std::max_element(layouts_.begin(), layouts_.end()) - layouts_.begin());
}

bool ModelInference::dual() const {
  return repeated_ + unrepeated_ > 0 ? repeated_ > unrepeated_ : 2 * dual_mode_ > packets_;
}

uint8_t ModelInference::product_id() const {
  return static_cast<uint8_t>(std::max_element(product_ids_.begin(), product_ids_.end()) -
                              product_ids_.begin());
}

int64_t ModelInference::median_period_us() const {
  auto periods = periods_us_;
  return median(std::span(periods).first(std::min<uint64_t>(periods_, kMaxPeriods)));
}

const ModelInfo* ModelInference::judge_info() const {
  if (packets_ < kMinPackets || periods_ == 0) return nullptr;
  const int64_t period_us = median_period_us();
  if (layout() == Layout::kFourBanks) return &model_info(Model::kVls128);
  if (layout() == Layout::kTwoBanks) return &hdl64e(period_us);
  const ModelInfo* named = named_model(product_id());
  if (named != nullptr && fits(*named, period_us, dual())) return named;
  const TimedModels timed = timed_models(period_us, dual());
  // A byte that is no model's tells nothing: the period decides if one model alone has it.
  if (named == nullptr) return timed.count == 1 ? timed.first : nullptr;
  return timed.first != nullptr ? timed.first : named;
}

const lidar::LidarModel* ModelInference::judge() const {
  const ModelInfo* judged = judge_info();
  return judged != nullptr ? &lidar_model(judged->model) : nullptr;
}

std::string ModelInference::spacing() const {
  std::string text = "packets " + std::to_string(median_period_us()) + " us apart";
  if (layout() == Layout::kOneBank && dual()) text += " with two returns";
  const long hundredths = std::lround(std::abs(turns_per_second()) * 100);
  return text + ", " + std::to_string(hundredths / 100) + (hundredths % 100 < 10 ? ".0" : ".") +
         std::to_string(hundredths % 100) + " turns per second";
}

std::string ModelInference::describe() const {
  if (packets_ == 0) return "no data packets";
  std::string text = "product byte ";  // one by one: gcc 12 sees a bound exceeded in their sum
  text.append(hex(product_id()));
  if (periods_ > 0) text.append(", ").append(spacing());
  return text;
}

std::optional<lidar::InferredModel> ModelInference::infer() const {
  const ModelInfo* judged = judge_info();
  if (judged == nullptr) return std::nullopt;
  const ModelInfo& info = *judged;
  const lidar::LidarModel* model = &lidar_model(info.model);
  if (info.banks == 4) return lidar::InferredModel{model, "blocks of lasers 96 ... 127"};
  if (info.banks == 2)
    return lidar::InferredModel{model, "blocks of lasers 32 ... 63, " + spacing()};
  const ModelInfo* named = named_model(product_id());
  const std::string claim = "product byte " + hex(product_id()) + " says " +
                            (named != nullptr ? named->name : "no known model");
  if (named != judged) {
    return lidar::InferredModel{model, spacing() + ": a " + info.name + "'s, though " + claim};
  }
  const bool fit = fits(info, median_period_us(), dual());
  return lidar::InferredModel{model, claim + ", " + spacing() + (fit ? "" : " fit no model")};
}

double ModelInference::turns_per_second() const {
  if (turning_us_ == 0) return 0;
  return static_cast<double>(turned_) / kCentidegreesPerTurn /
         (static_cast<double>(turning_us_) * 1e-6);
}

bool ModelInference::has_two_sensors() const {
  return tracks_.alternations() >= 20 && tracks_.alternations() * 20 >= packets_;
}

}  // namespace infuse::velodyne

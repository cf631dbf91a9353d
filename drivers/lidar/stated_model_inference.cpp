#include "drivers/lidar/stated_model_inference.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/lidar/azimuth.hpp"

namespace infuse::lidar {
namespace {

/// "9.99 turns per second".
std::string turns_text(double turns_per_second) {
  const long hundredths = std::lround(std::abs(turns_per_second) * 100);
  return std::to_string(hundredths / 100) + (hundredths % 100 < 10 ? ".0" : ".") +
         std::to_string(hundredths % 100) + " turns per second";
}

}  // namespace

void StatedModelInference::add(std::span<const uint8_t> payload) {
  const auto packet = reader_(payload);
  if (!packet) return;
  ++packets_;
  const auto votes = std::find_if(votes_.begin(), votes_.end(), [&](const Votes& each) {
    return each.packets == 0 || each.model == packet->model;
  });
  if (votes != votes_.end()) *votes = {packet->model, votes->packets + 1};
  const PacketTracks::Step step = tracks_.add(packet->counter, packet->azimuth);
  if (step.period_us <= 0) return;
  turned_ += step.advance;
  turning_us_ += step.period_us;
}

const LidarModel* StatedModelInference::judge() const {
  if (packets_ < min_packets()) return nullptr;
  return std::max_element(votes_.begin(), votes_.end(),
                          [](const Votes& a, const Votes& b) { return a.packets < b.packets; })
      ->model;
}

std::optional<InferredModel> StatedModelInference::infer() const {
  const LidarModel* judged = judge();
  if (judged == nullptr) return std::nullopt;
  return InferredModel{judged, "its packets say " + std::string(judged->name) + ", " +
                                   turns_text(turns_per_second())};
}

std::string StatedModelInference::describe() const {
  if (packets_ == 0) return "no data packets";
  return std::to_string(packets_) + " packets, " + turns_text(turns_per_second());
}

double StatedModelInference::turns_per_second() const {
  if (turning_us_ == 0) return 0;
  return static_cast<double>(turned_) / kCentidegreesPerTurn /
         (static_cast<double>(turning_us_) * 1e-6);
}

}  // namespace infuse::lidar

#include "drivers/lidar/stated_model_inference.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/lidar/azimuth.hpp"
#include "drivers/lidar/lidar_maker.hpp"

namespace infuse::lidar {
namespace {

/// Of so many packets one is read; odd, so that two sensors that alternate both are.
constexpr uint64_t kReadOf = 7;

/// "9.9 turns per second".
std::string turns_text(double turns_per_second) {
  const long tenths = std::lround(std::abs(turns_per_second) * 10);
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " turns per second";
}

}  // namespace

StatedModelInference::StatedModelInference(const LidarMaker& maker) : maker_(maker) {
  latest_.reserve(maker.max_datagram());
}

void StatedModelInference::add(std::span<const uint8_t> payload) {
  if (packets_++ % kReadOf != 0) return;
  const auto packet = maker_.read_stated(payload);
  if (!packet) return;
  latest_.assign(payload.begin(), payload.end());
  const auto votes = std::find_if(votes_.begin(), votes_.end(), [&](const Votes& each) {
    return each.packets == 0 || each.model == packet->model;
  });
  if (votes != votes_.end()) *votes = {packet->model, votes->packets + 1};
  if (packet->model == nullptr) return;
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
  return InferredModel{judged, "its packets say " + std::string(judged->name) + ": " + describe()};
}

std::string StatedModelInference::describe() const {
  if (latest_.empty()) return "no data packets";
  const std::string stated = maker_.describe(latest_);
  return std::to_string(latest_.size()) + " bytes, " + stated + (stated.empty() ? "" : ", ") +
         turns_text(turns_per_second());
}

double StatedModelInference::turns_per_second() const {
  if (turning_us_ <= 0) return 0;
  return static_cast<double>(turned_) * 1e6 /
         (kCentidegreesPerTurn * static_cast<double>(turning_us_));
}

}  // namespace infuse::lidar

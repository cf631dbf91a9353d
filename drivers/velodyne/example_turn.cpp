#include "drivers/velodyne/example_turn.hpp"

#include <cmath>

#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {
namespace {

constexpr double kAzimuthPerUs = 36'000e-5;  // 0.01 degrees at ten turns per second
constexpr uint32_t kBlockFlag = 0xEEFF;
constexpr uint32_t kReflectivity = 100;

}  // namespace

std::vector<uint8_t> example_packet(const ModelInfo& info, uint32_t index, double radius) {
  std::vector<uint8_t> bytes;
  bytes.reserve(kPacketSize);
  const auto put = [&](uint32_t value, size_t count) {
    for (size_t i = 0; i < count; ++i) bytes.push_back(static_cast<uint8_t>(value >> (8 * i)));
  };
  const double period_us = to_seconds(packet_period(info, info.cycle, false)) * 1e6;
  const double begin_us = index * period_us;
  const auto distance = static_cast<uint32_t>(std::lround(radius * 1e3 / info.distance_unit_mm));
  for (size_t block = 0; block < kBlocks; ++block) {
    const double us = begin_us + static_cast<double>(block) * period_us / kBlocks;
    put(kBlockFlag, 2);
    put(static_cast<uint32_t>(us * kAzimuthPerUs) % kCentidegreesPerTurn, 2);
    for (size_t i = 0; i < kSlotsPerBlock; ++i) {
      put(distance, 2);
      put(kReflectivity, 1);
    }
  }
  put(static_cast<uint32_t>(begin_us), 4);
  put(static_cast<uint32_t>(ReturnMode::kStrongest), 1);
  put(info.product_id, 1);
  return bytes;
}

}  // namespace infuse::velodyne

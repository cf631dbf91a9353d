#include "drivers/hesai/example_turn.hpp"

#include <cmath>

#include "drivers/hesai/packet.hpp"
#include "drivers/lidar/azimuth.hpp"

namespace infuse::hesai {

std::vector<uint8_t> example_packet(const ModelInfo& info, uint32_t index, double range) {
  constexpr double kUnitMm = 4, kAzimuthPerUs = 36'000e-5;  // 0.01° at ten turns per second
  constexpr uint8_t kReflectivity = 100;
  std::vector<uint8_t> bytes(info.body_end() + info.tail.size + 4);
  const auto put = [&](size_t at, uint64_t value, size_t count) {
    for (size_t i = 0; i < count; ++i) bytes[at + i] = static_cast<uint8_t>(value >> (8 * i));
  };
  put(0, 0xFFEE, 2);
  bytes[2] = info.protocol;
  bytes[6] = static_cast<uint8_t>(info.lasers);
  bytes[7] = info.blocks;
  bytes[9] = static_cast<uint8_t>(kUnitMm);
  const double period_us = to_seconds(info.period) * 1e6;
  const auto distance = static_cast<uint64_t>(std::lround(range * 1e3 / kUnitMm));
  for (size_t block = 0; block < info.blocks; ++block) {
    const size_t at = info.header_size + block * info.block_size();
    const double us =
        period_us * (index * static_cast<double>(info.blocks) + static_cast<double>(block));
    put(at, static_cast<uint64_t>(us * kAzimuthPerUs) % lidar::kCentidegreesPerTurn, 2);
    for (size_t channel = 0; channel < info.lasers; ++channel) {
      put(at + info.block_prefix + channel * info.unit_size, distance, 2);
      bytes[at + info.block_prefix + channel * info.unit_size + 2] = kReflectivity;
    }
  }
  // The date as seconds since 1970, the highest byte first, behind two zero bytes.
  const size_t tail = info.body_end();
  const auto us = static_cast<uint64_t>(index * period_us * info.blocks) + 1'000'000;
  bytes[tail + info.tail.return_mode] = static_cast<uint8_t>(ReturnMode::kStrongest);
  put(tail + info.tail.motor_speed, 600, 2);
  bytes[tail + info.tail.date + 5] = static_cast<uint8_t>(us / 1'000'000);
  put(tail + info.tail.microseconds, us % 1'000'000, 4);
  put(tail + info.tail.size, index, 4);
  return bytes;
}

}  // namespace infuse::hesai

#include "drivers/robosense/example_turn.hpp"

#include <cmath>

#include "drivers/lidar/azimuth.hpp"
#include "drivers/robosense/beam_table.hpp"
#include "drivers/robosense/packet.hpp"

namespace infuse::robosense {

std::vector<uint8_t> example_packet(uint32_t index, double range) {
  constexpr double kUnit = 0.0025, kAzimuthPerUs = 36'000e-5;  // m; 0.01° at ten turns per second
  constexpr uint8_t kReflectivity = 100, kHeliosType = 6;
  std::vector<uint8_t> bytes(kPacketSize);
  const auto put = [&](size_t at, uint64_t value, size_t count) {
    for (size_t i = 0; i < count; ++i) {
      bytes[at + i] = static_cast<uint8_t>(value >> (8 * (count - 1 - i)));
    }
  };
  const double period_us = kHeliosPeriodNs * 1e-3;
  const double begin_us = index * period_us * kBlocks;
  put(0, 0x55AA055A, 4);
  put(12, index, 4);
  bytes[17] = 1;  // the unit of distance
  put(20, static_cast<uint64_t>(begin_us / 1e6), 6);
  put(26, static_cast<uint64_t>(begin_us) % 1'000'000, 4);
  bytes[30] = kHeliosType;
  for (size_t block = 0; block < kBlocks; ++block) {
    const size_t at = kHeaderSize + block * kBlockSize;
    const double us = begin_us + static_cast<double>(block) * period_us;
    put(at, 0xFFEE, 2);
    put(at + 2, static_cast<uint64_t>(us * kAzimuthPerUs) % lidar::kCentidegreesPerTurn, 2);
    for (size_t channel = 0; channel < kChannels; ++channel) {
      put(at + kBlockPrefix + channel * kUnitSize, static_cast<uint64_t>(range / kUnit), 2);
      bytes[at + kBlockPrefix + channel * kUnitSize + 2] = kReflectivity;
    }
  }
  return bytes;
}

}  // namespace infuse::robosense

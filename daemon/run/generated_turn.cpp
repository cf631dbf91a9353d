#include "daemon/run/generated_turn.hpp"

#include <cmath>

namespace infuse::daemon {
namespace {

constexpr double kUnit = 0.002;              // m, of a distance
constexpr double kAzimuthPerUs = 36'000e-5;  // 0.01 degrees at ten turns per second
constexpr uint8_t kStrongestReturn = 0x37, kVlp16 = 0x22;

}  // namespace

std::array<uint8_t, velodyne::kPacketSize> generated_packet(uint32_t index, double radius) {
  std::array<uint8_t, velodyne::kPacketSize> bytes{};
  size_t at = 0;
  const auto put = [&](uint32_t value, size_t count) {
    for (size_t i = 0; i < count; ++i) bytes[at++] = static_cast<uint8_t>(value >> (8 * i));
  };
  const double begin_us = index * kGeneratedPacketUs;
  for (size_t block = 0; block < velodyne::kBlocks; ++block) {
    const double us =
        begin_us + static_cast<double>(block) * kGeneratedPacketUs / velodyne::kBlocks;
    put(0xEEFF, 2);
    put(static_cast<uint32_t>(us * kAzimuthPerUs) % velodyne::kCentidegreesPerTurn, 2);
    for (int i = 0; i < 32; ++i) {
      put(static_cast<uint32_t>(std::lround(radius / kUnit)), 2);
      put(100, 1);
    }
  }
  put(static_cast<uint32_t>(begin_us), 4);
  put(kStrongestReturn, 1);
  put(kVlp16, 1);
  return bytes;
}

}  // namespace infuse::daemon

#pragma once

#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/lidar/little_endian.hpp"

/// A maker that does not exist. Its packet: "Rng!", number (u32), device time (u64, ns); then 8
/// times azimuth (u16, 0.01°) and the distances of 4 beams (u16, cm), 0.1 rad and 100 µs apart.
namespace infuse::made_up {

inline constexpr size_t kSequences = 8, kBeams = 4, kHeader = 16, kBlock = 2 + 2 * kBeams;
inline constexpr size_t kPacket = kHeader + kSequences * kBlock;
inline constexpr uint32_t kMark = 0x21676E52;
inline constexpr Duration kPeriod{100'000};

inline Duration read_time(std::span<const uint8_t> payload) {
  return Duration(static_cast<int64_t>(lidar::read_u64(&payload[8])));
}

struct Decoder final : lidar::LidarDecoder {
  explicit Decoder(const lidar::DecoderOptions& options)
      : LidarDecoder(options, {.modulo = Duration(0), .synchronised = ClockState::Source::kUtc},
                     {kPeriod.count(), 108}) {}

  const char* parse(std::span<const uint8_t> payload, lidar::PacketHeader& header) const override {
    if (payload.size() != kPacket) return "the payload is not 96 bytes";
    header.number = lidar::read_u32(&payload[4]);
    header.counter = read_time(payload);
    header.sequences = kSequences;
    for (size_t i = 0; i < kSequences; ++i)
      header.azimuth[i] = lidar::read_u16(&payload[kHeader + i * kBlock]);
    return nullptr;
  }

  void append(const lidar::HeldPacket& packet, const lidar::FiringPlan& plan, size_t first,
              size_t last, lidar::SweepWriter& writer) override {
    for (size_t i = first; i < last; ++i) {
      const auto& planned = plan.sequences[i];
      writer.add_sequence(planned, packet.device_ns + planned.time_ns, 1);
      for (uint16_t beam = 0; beam < kBeams; ++beam) {
        const int cm = lidar::read_u16(&packet.payload[kHeader + i * kBlock + 2 + 2 * beam]);
        if (cm > 0) writer.add_return(beam, cm * 0.01, 0.1 * beam - 0.2);
      }
    }
  }
};

struct Maker final : lidar::LidarMaker {
  Maker() : LidarMaker("Made up", {7777, 7777}, {{.name = "Ringer 4", .beams = kBeams}}) {}

  lidar::PacketClass classify(std::span<const uint8_t> payload) const override {
    const bool own = payload.size() == kPacket && lidar::read_u32(payload.data()) == kMark;
    return own ? lidar::PacketClass::kData : lidar::PacketClass::kOther;
  }
  std::optional<lidar::StatedPacket> read_stated(std::span<const uint8_t> payload) const override {
    return lidar::StatedPacket{&models()[0], read_time(payload),
                               lidar::read_u16(&payload[kHeader])};
  }
  Result<std::unique_ptr<lidar::LidarDecoder>> new_decoder(
      const lidar::DecoderOptions& options) const override {
    return std::make_unique<Decoder>(options);
  }
};

inline const Maker only_maker;
inline const Maker& maker() { return only_maker; }

}  // namespace infuse::made_up

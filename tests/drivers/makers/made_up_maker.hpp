#pragma once

#include <array>
#include <cmath>

#include "drivers/lidar/azimuth_table.hpp"
#include "drivers/lidar/lidar_maker.hpp"
#include "drivers/lidar/little_endian.hpp"
#include "drivers/lidar/stated_model_inference.hpp"

/// A maker that does not exist. Its packet: "Rng!", number (u32), device time (u64, ns); then 8
/// times azimuth (u16, 0.01°) and the distances of 4 beams (u16, cm), 100 µs apart.
namespace infuse::made_up {

inline constexpr size_t kSequences = 8, kBeams = 4, kHeader = 16, kBlock = 2 + 2 * kBeams;
inline constexpr size_t kPacket = kHeader + kSequences * kBlock;
inline constexpr Duration kPeriod{100'000};
inline constexpr std::array kElevations{-0.2, -0.1, 0.0, 0.1};  // rad

const lidar::LidarModel& model();

class Decoder final : public lidar::LidarDecoder {
 public:
  explicit Decoder(const lidar::DecoderOptions& options)
      : LidarDecoder(options, {.modulo = Duration(0), .synchronised = ClockState::Source::kUtc},
                     {kPeriod.count(), 108}) {}

 private:
  const char* parse(std::span<const uint8_t> payload, lidar::PacketHeader& header) const override {
    if (payload.size() != kPacket) return "the payload is not 96 bytes";
    header.number = lidar::read_u32(&payload[4]);
    header.counter = Duration(static_cast<int64_t>(lidar::read_u64(&payload[8])));
    header.sequences = kSequences;
    for (size_t i = 0; i < kSequences; ++i) {
      header.azimuth[i] = lidar::read_u16(&payload[kHeader + i * kBlock]);
    }
    return nullptr;
  }

  void append(const lidar::HeldPacket& packet, const lidar::FiringPlan& plan, size_t first,
              size_t last, lidar::SweepWriter& writer) override {
    static const lidar::AzimuthTable azimuths;
    const lidar::ReturnArrays arrays = writer.make_room((last - first) * kBeams);
    size_t size = writer.size();
    for (size_t i = first; i < last; ++i) {
      const auto& planned = plan.sequences[i];
      const auto place = writer.add_sequence(planned, packet.device_ns + planned.time_ns, 1);
      const auto [cos, sin] = azimuths.at(planned.azimuth);
      for (size_t beam = 0; beam < kBeams; ++beam) {
        const uint8_t* bytes = &packet.payload[kHeader + i * kBlock + 2 + 2 * beam];
        const float range = static_cast<float>(lidar::read_u16(bytes)) * 0.01F;
        const auto flat = range * static_cast<float>(std::cos(kElevations[beam]));
        const auto z = range * static_cast<float>(std::sin(kElevations[beam]));
        const auto ring = static_cast<uint16_t>(beam);
        if (range > 0) {
          arrays.set(size++, {flat * cos, -flat * sin, z, range, 0.5F, ring, place.column,
                              place.time_offset_ns, ReturnKind::kStrongest});
        }
      }
    }
    writer.set_size(size, 0);
  }
};

class Maker final : public lidar::LidarMaker {
 public:
  const char* name() const override { return "Made up"; }
  std::span<const lidar::LidarModel> models() const override { return {&model_, 1}; }
  lidar::PacketClass classify(std::span<const uint8_t> payload) const override {
    const bool own = payload.size() == kPacket && lidar::read_u32(payload.data()) == 0x21676E52;
    return own ? lidar::PacketClass::kData : lidar::PacketClass::kOther;
  }
  std::unique_ptr<lidar::ModelInference> make_inference() const override {
    return std::make_unique<lidar::StatedModelInference>(&read, Duration(0));
  }
  Result<std::unique_ptr<lidar::LidarDecoder>> make_decoder(
      const lidar::DecoderOptions& options) const override {
    return std::make_unique<Decoder>(options);
  }
  lidar::LidarPorts ports() const override { return {7777, 7777}; }

 private:
  static std::optional<lidar::StatedModelInference::Packet> read(std::span<const uint8_t> payload) {
    if (payload.size() != kPacket) return std::nullopt;
    return lidar::StatedModelInference::Packet{
        &model(), Duration(static_cast<int64_t>(lidar::read_u64(&payload[8]))),
        lidar::read_u16(&payload[kHeader])};
  }
  lidar::LidarModel model_{.maker = this, .name = "Ringer 4", .beams = kBeams};
};

inline const Maker& maker() {
  static const Maker maker;
  return maker;
}
inline const lidar::LidarModel& model() { return maker().models()[0]; }

/// The packet `index` of a sensor in the middle of a cylinder of this radius, m, that turns ten
/// times a second; the first one fires at `start`.
inline std::vector<uint8_t> packet(uint32_t index, Stamp start, double radius) {
  std::vector<uint8_t> bytes;
  const auto put = [&](uint64_t value, size_t count) {
    for (size_t i = 0; i < count; ++i) bytes.push_back(static_cast<uint8_t>(value >> (8 * i)));
  };
  put(0x21676E52, 4);
  put(index, 4);
  put(static_cast<uint64_t>((start + index * kSequences * kPeriod).ns()), 8);
  for (size_t i = 0; i < kSequences; ++i) {
    put((index * kSequences + i) % 1000 * 36, 2);
    for (const double elevation : kElevations) {
      put(static_cast<uint64_t>(std::lround(radius / std::cos(elevation) * 100)), 2);
    }
  }
  return bytes;
}

}  // namespace infuse::made_up

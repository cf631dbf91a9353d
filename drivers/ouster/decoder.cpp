#include "drivers/ouster/decoder.hpp"

#include <algorithm>
#include <memory>
#include <span>

#include "drivers/ouster/imu_packet.hpp"
#include "drivers/ouster/turn_assembler.hpp"

namespace infuse::ouster {
namespace {

const Metadata& metadata_of(const lidar::DecoderOptions& options) {
  return static_cast<const UnitCalibration&>(*options.calibration).metadata;
}

/// Options of the device's clock: 64 bits of nanoseconds, which never wrap.
ClockModelOptions clock_options(TimeMode mode) {
  ClockModelOptions options;
  options.modulo = Duration::zero();
  switch (mode) {
    case TimeMode::kPtp:
      options.synchronised = ClockState::Source::kPtp;
      options.hour_tolerance = Duration(60'000'000'000);  // a master's time may be TAI
      break;
    case TimeMode::kPps:
    case TimeMode::kUnknown:
      options.synchronised = ClockState::Source::kUtc;
      break;
    case TimeMode::kInternal:
      break;
  }
  return options;
}

}  // namespace

Decoder::Decoder(const lidar::DecoderOptions& options)
    : LidarDecoder(options,
                   [&](lidar::PacketCounters& counters, lidar::Losses& losses) {
                     const Metadata& metadata = metadata_of(options);
                     return std::make_unique<TurnAssembler>(
                         metadata, options, clock_options(metadata.time_mode), counters, losses);
                   }),
      calibration_(options.calibration),
      metadata_(metadata_of(options)),
      layout_(metadata_) {}

const char* Decoder::parse(std::span<const uint8_t> payload, lidar::PacketHeader& header) const {
  const auto packet = parse_packet(layout_, payload);
  if (!packet) return describe(packet.error());
  header.sequences = static_cast<uint8_t>(packet->count);
  const std::span columns = std::span(packet->columns).first(packet->count);
  const auto first = std::ranges::find(columns, true, &Column::valid);
  if (first != columns.end()) header.counter = Duration(first->device_ns);
  return nullptr;
}

const char* Decoder::read_inertial(const Datagram& datagram) {
  const auto packet = parse_imu_packet(datagram.payload);
  if (!packet) return "an inertial packet with impossible numbers";
  // Before the first lidar packet the device's clock is not known.
  const Stamp stamp = counters().packets > 0 ? to_host(Duration(packet->gyro_ns)) : datagram.stamp;
  give(to_sample(*packet, metadata_.T_sensor_imu, stamp));
  return nullptr;
}

}  // namespace infuse::ouster

#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {
namespace {

/// Flag at the beginning of a block of each bank.
constexpr std::array<uint16_t, 4> kBankFlags{0xEEFF, 0xDDFF, 0xCCFF, 0xBBFF};

/// An HDL-64E S3 with two returns repeats each azimuth: blocks 0 1 0 1 2 3 2 3 4 5 4 5.
bool repeats_azimuths(std::span<const uint8_t> payload) {
  const auto azimuth = [&](size_t block) { return read_u16(block_at(payload, block) + 2); };
  const bool repeats =
      azimuth(0) == azimuth(2) && azimuth(4) == azimuth(6) && azimuth(8) == azimuth(10);
  const bool turns = azimuth(0) != azimuth(4) || azimuth(4) != azimuth(8);
  return repeats && turns;
}

ReturnMode read_mode(const ModelInfo& info, std::span<const uint8_t> payload) {
  if (info.calibrated_per_unit) {
    return info.has_dual_return && repeats_azimuths(payload) ? ReturnMode::kDual
                                                             : ReturnMode::kStrongest;
  }
  switch (payload[kReturnModeOffset]) {
    case static_cast<uint8_t>(ReturnMode::kDual):
      return ReturnMode::kDual;
    case static_cast<uint8_t>(ReturnMode::kLast):
      return ReturnMode::kLast;
    default:
      return ReturnMode::kStrongest;  // the byte is arbitrary in early firmware
  }
}

}  // namespace

const char* describe(PacketFault fault) {
  switch (fault) {
    case PacketFault::kSize:
      return "the payload is not 1206 bytes";
    case PacketFault::kFlag:
      return "a block does not begin with a flag of this model";
    case PacketFault::kAzimuth:
      return "most azimuths are above 360 degrees";
    case PacketFault::kDualPair:
      return "the two returns of a pair differ in azimuth";
    case PacketFault::kReturnMode:
      return "this model does not send two returns";
  }
  return "";
}

BlockLayout block_layout(const ModelInfo& info, bool dual_return) {
  const auto banks = static_cast<uint8_t>(info.banks);
  if (!dual_return) return {banks, 1, 0};
  const auto both = static_cast<uint8_t>(2 * banks);
  // HDL-64E: all banks of one echo, then all of the other. Other models: pairs of echoes.
  return info.calibrated_per_unit ? BlockLayout{both, 1, banks} : BlockLayout{both, 2, 1};
}

tl::expected<Packet, PacketFault> parse_packet(const ModelInfo& info,
                                               std::span<const uint8_t> payload) {
  if (payload.size() != kPacketSize) return tl::unexpected(PacketFault::kSize);
  Packet packet;
  packet.mode = read_mode(info, payload);
  if (packet.dual() && !info.has_dual_return) return tl::unexpected(PacketFault::kReturnMode);
  packet.counter_us = read_u32(payload.data() + kCounterOffset);
  packet.status_type = payload[kReturnModeOffset];
  packet.product_id = payload[kProductIdOffset];
  packet.sequences = static_cast<uint8_t>(info.sequences_per_packet(packet.dual()));

  const BlockLayout layout = block_layout(info, packet.dual());
  const size_t echoes = packet.dual() ? 2 : 1;
  size_t impossible = 0;
  for (size_t i = 0; i < packet.sequences; ++i) {
    const uint16_t azimuth = read_u16(block_at(payload, layout.block(i, 0, 0)) + 2);
    if (azimuth > kCentidegreesPerTurn) {
      packet.azimuth[i] = kNoAzimuth;
      ++impossible;
    } else {
      packet.azimuth[i] = azimuth % kCentidegreesPerTurn;  // 360.00° occurs
    }
    for (size_t b = 0; b < info.banks; ++b) {
      for (size_t e = 0; e < echoes; ++e) {
        const uint8_t* block = block_at(payload, layout.block(i, b, e));
        if (read_u16(block) != kBankFlags[b]) return tl::unexpected(PacketFault::kFlag);
        if (e > 0 && read_u16(block + 2) != azimuth) return tl::unexpected(PacketFault::kDualPair);
      }
    }
  }
  if (2 * impossible > packet.sequences) return tl::unexpected(PacketFault::kAzimuth);
  return packet;
}

}  // namespace infuse::velodyne

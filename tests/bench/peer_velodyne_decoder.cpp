#include "tests/bench/peer_velodyne_decoder.hpp"

#include <velodyne_decoder/stream_decoder.h>

#include <cstring>

namespace infuse::bench {
namespace {

constexpr size_t kFileHeader = 24, kRecordHeader = 16;  // of pcap
constexpr size_t kHeaders = 14 + 20 + 8;                // Ethernet, IPv4, UDP

uint32_t word(const uint8_t* at) {
  uint32_t value = 0;
  std::memcpy(&value, at, sizeof value);
  return value;
}

}  // namespace

size_t decode_by_peer(std::span<const uint8_t> pcap) {
  velodyne_decoder::Config config;
  config.model = velodyne_decoder::ModelId::HDL32E;
  config.cut_angle = 0.0F;
  velodyne_decoder::StreamDecoder decoder(config);
  size_t returns = 0;
  for (size_t at = kFileHeader; at + kRecordHeader <= pcap.size();) {
    const uint8_t* record = pcap.data() + at;
    const size_t size = word(record + 8);
    at += kRecordHeader + size;
    if (at > pcap.size() || size != kHeaders + velodyne_decoder::PACKET_SIZE) continue;
    const double stamp = word(record) + 1e-6 * word(record + 4);
    const auto scan = decoder.decode(
        {stamp, gsl::span<const uint8_t, velodyne_decoder::PACKET_SIZE>(
                    record + kRecordHeader + kHeaders, velodyne_decoder::PACKET_SIZE)});
    if (scan) returns += scan->second.size();
  }
  if (const auto last = decoder.finish()) returns += last->second.size();
  return returns;
}

}  // namespace infuse::bench

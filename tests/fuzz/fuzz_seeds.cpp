// Writes seeds of the fuzzers, one folder for each: packets of every Velodyne model, sound and
// after every family of mutations; captures of every link type. Usage: fuzz_seeds FOLDER

#include <filesystem>
#include <fstream>
#include <iostream>

#include "fixtures/velodyne/db_xml.hpp"
#include "fixtures/velodyne/position_encoder.hpp"
#include "tests/drivers/recording/capture_bytes.hpp"
#include "tests/drivers/velodyne/mutation_families.hpp"

namespace {

using namespace infuse;
using namespace infuse::velodyne;

constexpr size_t kPacketsEach = 4;

template <class Bytes>
void write_seed(const std::filesystem::path& path, const Bytes& bytes) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

/// As velodyne_packet_fuzz reads it: the model, then packets.
void write_packets(const std::filesystem::path& path, size_t model,
                   const std::vector<SentPacket>& packets) {
  std::vector<uint8_t> bytes = {static_cast<uint8_t>(model)};
  for (size_t i = 0; i < std::min(packets.size(), kPacketsEach); ++i) {
    bytes.insert(bytes.end(), packets[i].payload.begin(), packets[i].payload.end());
  }
  write_seed(path, bytes);
}

void write_data_packets(const std::filesystem::path& folder) {
  std::mt19937 random(1);
  for (size_t i = 0; i < models().size(); ++i) {
    const ModelInfo& info = models()[i];
    for (const ReturnMode mode : {ReturnMode::kStrongest, ReturnMode::kDual}) {
      if (mode == ReturnMode::kDual && !info.has_dual_return) continue;
      const std::string name =
          std::to_string(i) + (mode == ReturnMode::kDual ? "_dual_" : "_single_");
      auto packets = make_scene({.model = info.model,
                                 .mode = mode,
                                 .turns = 0.05,
                                 .calibration = built_in_calibration(info.model)})
                         .packets;
      packets.resize(std::min(packets.size(), kPacketsEach));
      write_packets(folder / (name + "sound"), i, packets);
      for (const MutationFamily& family : mutation_families()) {
        auto mutated = packets;
        family.apply(mutated, random);
        write_packets(folder / (name + family.name), i, mutated);
      }
    }
  }
}

/// As pcap_fuzz reads them: the number of the link type, then frames after their lengths.
void write_captures(const std::filesystem::path& folder) {
  using namespace recording::testing;
  const Bytes payload = make_payload(64);
  const Bytes packet = ipv4(udp(payload));
  Bytes longer = packet;  // as VeloView saves position packets
  longer[2] = 4;
  Bytes null = {2, 0, 0, 0};  // AF_INET before the packet
  Bytes loop = {0, 0, 0, 2};
  add(null, packet);
  add(loop, packet);
  const std::vector<std::vector<Bytes>> captures = {
      {null},
      {ethernet(packet), ethernet(packet, {{0x8100, 5}}),
       ethernet(packet, {{0x88A8, 1}, {0x8100, 2}}), ethernet(longer),
       ethernet(ipv4(payload, {.protocol = 6})), ethernet(packet, {}, 0x86DD)},
      {packet, ipv4(udp(payload), {.option_words = 3})},
      {loop},
      {linux_cooked_v1(packet)},
      {packet},
      {linux_cooked_v2(packet)},
      {ethernet(ipv4({payload.begin(), payload.begin() + 32}, {.identification = 7, .more = true})),
       ethernet(ipv4({payload.begin() + 32, payload.end()}, {.identification = 7, .offset = 32}))},
  };
  for (size_t link = 0; link < captures.size(); ++link) {
    Bytes bytes = {static_cast<uint8_t>(link)};
    for (const Bytes& frame : captures[link]) {
      bytes.push_back(static_cast<uint8_t>(frame.size()));
      add(bytes, frame);
    }
    write_seed(folder / std::to_string(link), bytes);
  }
  write_seed(folder / "pcap", pcap(kEthernet, {{1, 0, ethernet(packet)}}));
  write_seed(folder / "pcapng", pcapng(kEthernet, {{1, 0, ethernet(packet)}}));
  write_seed(folder / ".." / "udp_tap_fuzz" / "packet", packet);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: fuzz_seeds FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  write_data_packets(folder / "velodyne_packet_fuzz");
  write_captures(folder / "pcap_fuzz");
  const std::string sentence = fixtures::rmc_sentence(
      {.utc_ns = 1'700'000'000'000'000'000, .latitude = 0.8, .longitude = -2.1});
  write_seed(folder / "velodyne_position_fuzz" / "rmc",
             fixtures::encode_position_packet({.counter_us = 5, .sentence = sentence}));
  for (const Model model : {Model::kHdl64eS2, Model::kHdl64eS3}) {
    write_seed(folder / "velodyne_db_xml_fuzz" / std::to_string(static_cast<int>(model)),
               fixtures::write_db_xml(built_in_calibration(model)));
  }
  return 0;
}

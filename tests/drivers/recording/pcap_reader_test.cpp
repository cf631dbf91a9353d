#include "drivers/recording/pcap_reader.hpp"

#include <gtest/gtest.h>

#include <random>

#include "drivers/measurement/ipv4_address.hpp"
#include "tests/drivers/recording/capture_bytes.hpp"
#include "tests/drivers/recording/read_pcap.hpp"
#include "tests/real_data.hpp"

namespace infuse::recording {
namespace {

using namespace testing;

TEST(PcapReader, AllLinkTypesGiveTheSamePayload) {
  const Bytes payload = make_payload(1206);
  const Bytes packet = ipv4(udp(payload, 2368, 40000));
  Bytes null_frame = {2, 0, 0, 0}, loop_frame = {0, 0, 0, 2};
  add(null_frame, packet);
  add(loop_frame, packet);
  const std::vector<std::pair<uint32_t, Bytes>> frames = {
      {kEthernet, ethernet(packet)},
      {kEthernet, ethernet(packet, {{0x8100, 5}})},
      {kEthernet, ethernet(packet, {{0x88A8, 5}, {0x8100, 6}})},
      {kEthernet, ethernet(packet, {{0x9100, 5}, {0x8100, 6}})},
      {kCooked1, linux_cooked_v1(packet)},
      {kCooked2, linux_cooked_v2(packet)},
      {kRaw, packet},
      {kIpv4Link, packet},
      {kNull, null_frame},
      {kLoop, loop_frame},
  };
  for (const auto& [link_type, frame] : frames) {
    SCOPED_TRACE("link type " + std::to_string(link_type));
    const std::vector<Record> records = {{1'700'000'000, 123'456'789, frame}};
    for (const Bytes& file : {pcap(link_type, records), pcapng(link_type, records)}) {
      const PcapOutcome outcome = read_pcap(file);
      ASSERT_EQ(outcome.datagrams.size(), 1u);
      EXPECT_EQ(outcome.datagrams[0].payload, payload);
      EXPECT_EQ(outcome.datagrams[0].sender, kSender);
      EXPECT_EQ(outcome.datagrams[0].port, 2368);
      EXPECT_EQ(outcome.datagrams[0].ns, 1'700'000'000'123'456'789);
      EXPECT_FALSE(outcome.damage);
    }
  }
}

TEST(PcapReader, ReadsMicrosecondAndBigEndianFiles) {
  const Bytes frame = ethernet(ipv4(udp(make_payload(10))));
  const PcapOutcome little = read_pcap(pcap(kEthernet, {{100, 999'999, frame}}, false));
  ASSERT_EQ(little.datagrams.size(), 1u);
  EXPECT_EQ(little.datagrams[0].ns, 100'999'999'000);

  Bytes big;
  for (const uint32_t word : {0xA1B2C3D4u, 0x0002'0004u, 0u, 0u, 65535u, kEthernet, 7u, 8u}) {
    add_be32(big, word);
  }
  add_be32(big, static_cast<uint32_t>(frame.size()));
  add_be32(big, static_cast<uint32_t>(frame.size()));
  add(big, frame);
  const PcapOutcome outcome = read_pcap(big);
  ASSERT_EQ(outcome.datagrams.size(), 1u);
  EXPECT_EQ(outcome.datagrams[0].ns, 7'000'008'000);
  EXPECT_EQ(outcome.datagrams[0].payload, make_payload(10));
}

TEST(PcapReader, EthernetPaddingAndIpOptionsAreNotPayload) {
  Bytes padded = ethernet(ipv4(udp(make_payload(4)), {.option_words = 3}));
  padded.resize(padded.size() + 17, 0);
  const PcapOutcome outcome = read_pcap(pcap(kEthernet, {{1, 0, padded}}));
  ASSERT_EQ(outcome.datagrams.size(), 1u);
  EXPECT_EQ(outcome.datagrams[0].payload, make_payload(4));
}

TEST(PcapReader, FiltersByPortAndSender) {
  std::vector<Record> records;
  for (const uint32_t sender : {0x0A000001u, 0x0A000002u}) {
    for (const uint16_t port : std::vector<uint16_t>{2368, 2369, 8308}) {
      records.push_back({1, 0, ethernet(ipv4(udp(make_payload(8), port), {.sender = sender}))});
    }
  }
  const Bytes file = pcap(kEthernet, records);
  EXPECT_EQ(read_pcap(file).datagrams.size(), 6u);
  const PcapOutcome ports = read_pcap(file, {.ports = {2368, 8308}, .senders = {}});
  EXPECT_EQ(ports.datagrams.size(), 4u);
  EXPECT_EQ(ports.counters.filtered, 2u);
  const PcapOutcome both = read_pcap(file, {.ports = {2369}, .senders = {0x0A000002}});
  ASSERT_EQ(both.datagrams.size(), 1u);
  EXPECT_EQ(both.datagrams[0].sender, 0x0A000002u);
  EXPECT_EQ(both.datagrams[0].port, 2369);
}

/// Ousters send IPv6 to a host whose name has such an address.
TEST(PcapReader, DatagramsAndFragmentsOfIpv6AreRead) {
  const Bytes large = udp(make_payload(3'000, 5), 7502, 7502);
  const auto part = [&](size_t from, size_t size, bool more) {
    const auto begin = large.begin() + static_cast<ptrdiff_t>(from);
    return ethernet(
        ipv6(Bytes(begin, begin + static_cast<ptrdiff_t>(size)),
             {.identification = 70'000, .offset = from, .more = more, .fragment = true}),
        {}, 0x86DD);
  };
  Bytes bad_option = ipv6(udp(make_payload(10)), {.options = true});
  bad_option[41] = 200;
  const PcapOutcome outcome = read_pcap(pcap(
      kEthernet, {
                     {1, 0, ethernet(ipv6(udp(make_payload(100))), {}, 0x86DD)},
                     {2, 0, ethernet(ipv6(udp(make_payload(90)), {.options = true}), {}, 0x86DD)},
                     {3, 0, part(1'448, 1'448, true)},
                     {3, 1, part(0, 1'448, true)},
                     {3, 2, part(2'896, large.size() - 2'896, false)},
                     {4, 0, ethernet(ipv6(make_payload(40), {.protocol = 58}), {}, 0x86DD)},
                     {5, 0, ethernet(bad_option, {}, 0x86DD)},
                 }));
  ASSERT_EQ(outcome.datagrams.size(), 3u);
  EXPECT_EQ(outcome.datagrams[0].payload, make_payload(100));
  EXPECT_EQ(outcome.datagrams[1].payload, make_payload(90));
  EXPECT_EQ(outcome.datagrams[2].payload, make_payload(3'000, 5));
  EXPECT_EQ(outcome.datagrams[2].port, 7502);
  EXPECT_EQ(outcome.datagrams[2].sender, 0xF0A801C9u);
  EXPECT_EQ(address_text(outcome.datagrams[2].sender), "IPv6 ...0a8:01c9");
  EXPECT_EQ(outcome.counters.fragments, 3u);
  EXPECT_EQ(outcome.counters.ipv6, 1u);
  EXPECT_EQ(outcome.counters.malformed, 1u);
}

TEST(PcapReader, ReassemblesFragmentsInAnyOrder) {
  const Bytes a = make_payload(5000, 1), b = make_payload(3001, 2);
  std::vector<Bytes> frames = make_fragments(udp(a), 1480, 77);
  for (const Bytes& frame : make_fragments(udp(b), 1480, 78)) frames.push_back(frame);
  frames.push_back(frames.front());  // a duplicate, before or after its datagram is complete
  std::mt19937 random(4);
  for (int round = 0; round < 50; ++round) {
    std::shuffle(frames.begin(), frames.end(), random);
    std::vector<Record> records;
    for (const Bytes& frame : frames) records.push_back({5, 0, frame});
    const PcapOutcome outcome = read_pcap(pcap(kEthernet, records));
    ASSERT_EQ(outcome.datagrams.size(), 2u);
    const bool a_first = outcome.datagrams[0].payload.size() == a.size();
    EXPECT_EQ(outcome.datagrams[a_first ? 0 : 1].payload, a);
    EXPECT_EQ(outcome.datagrams[a_first ? 1 : 0].payload, b);
    EXPECT_EQ(outcome.counters.fragments, frames.size());
    EXPECT_LE(outcome.counters.fragments_dropped, 1u);
  }
}

TEST(PcapReader, FragmentsOfTwoSendersAreNotMixed) {
  const Bytes a = make_payload(2000, 1), b = make_payload(2000, 9);
  const auto of_a = make_fragments(udp(a), 1480, 5, 1), of_b = make_fragments(udp(b), 1480, 5, 2);
  const PcapOutcome outcome = read_pcap(
      pcap(kEthernet, {{1, 0, of_a[0]}, {1, 0, of_b[0]}, {1, 0, of_b[1]}, {1, 0, of_a[1]}}));
  ASSERT_EQ(outcome.datagrams.size(), 2u);
  EXPECT_EQ(outcome.datagrams[0].payload, b);
  EXPECT_EQ(outcome.datagrams[0].sender, 2u);
  EXPECT_EQ(outcome.datagrams[1].payload, a);
  EXPECT_EQ(outcome.datagrams[1].sender, 1u);
}

// Packet counts and durations from data/INDEX.md. For the VLP-32C it states the duration by the
// device's clock (0.450 s); the receive stamps, read with a hex editor, span 0.499 s.
TEST(PcapReader, RealVelodyneCapturesMatchTheirIndex) {
  INFUSE_REAL_DATA_OR_SKIP(path, "velodyne");
  struct Expected {
    const char* file;
    size_t data, position;
    double span_s;
  };
  for (const Expected& expected : {Expected{"hdl32e-monterey.pcap", 2702, 299, 1.494},
                                   {"hdl32e-moving.pcap", 876, 100, 0.484},
                                   {"vlp16-gps.pcap", 293, 57, 0.388},
                                   {"vlp16-dual-return.pcap", 603, 0, 0.399},
                                   {"vlp32c-half-turn.pcap", 379, 0, 0.499}}) {
    SCOPED_TRACE(expected.file);
    auto reader = PcapReader::open(path / expected.file);
    ASSERT_TRUE(reader);
    size_t data = 0, position = 0;
    Stamp first = Stamp::latest(), last = Stamp::earliest();
    Datagram datagram;
    while (reader->next(datagram)) {
      data += datagram.destination_port == 2368 && datagram.payload.size() == 1206;
      position += datagram.destination_port == 8308 && datagram.payload.size() == 512;
      first = std::min(first, datagram.stamp);
      last = std::max(last, datagram.stamp);
    }
    EXPECT_EQ(data, expected.data);
    EXPECT_EQ(position, expected.position);
    EXPECT_NEAR(to_seconds(last - first), expected.span_s, 0.002);
    EXPECT_FALSE(reader->damage());
    EXPECT_EQ(reader->counters().datagrams, data + position);
  }
}

}  // namespace
}  // namespace infuse::recording

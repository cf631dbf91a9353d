#include "drivers/recording/pcap_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "drivers/measurement/ipv4_address.hpp"
#include "tests/drivers/recording/capture_bytes.hpp"
#include "tests/real_data.hpp"

namespace infuse::recording {
namespace {

using namespace testing;
using ::testing::HasSubstr;

struct Received {
  int64_t ns;
  uint32_t sender;
  uint16_t port;
  Bytes payload;
};

struct PcapOutcome {
  std::vector<Received> datagrams;
  PcapCounters counters;
  std::optional<Error> damage;
};

PcapOutcome read_pcap(PcapReader reader) {
  PcapOutcome outcome;
  Datagram datagram;
  while (reader.next(datagram)) {
    outcome.datagrams.push_back({datagram.stamp.ns(), datagram.sender, datagram.destination_port,
                                 Bytes(datagram.payload.begin(), datagram.payload.end())});
  }
  EXPECT_FALSE(reader.next(datagram)) << "next() must keep returning false at the end";
  outcome.counters = reader.counters();
  outcome.damage = reader.damage();
  return outcome;
}

PcapOutcome read_pcap(const Bytes& file, const PcapOptions& options = {}) {
  auto reader = PcapReader::from_bytes(file, "test.pcap", options);
  if (!reader) {
    ADD_FAILURE() << reader.error().message();
    return {};
  }
  return read_pcap(std::move(*reader));
}

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

TEST(PcapReader, CountsSkippedPackets) {
  const Bytes packet = ipv4(udp(make_payload(100)));
  Bytes long_udp = udp(make_payload(10));
  long_udp[5] = 200;  // a length that exceeds the packet
  Bytes tiny_udp = udp(make_payload(10));
  tiny_udp[5] = 7;
  Bytes long_ip = packet;
  long_ip[2] = 0x7F;
  Bytes short_header = packet;
  short_header[0] = 0x44;
  const PcapOutcome outcome = read_pcap(
      pcap(kEthernet, {
                          {1, 0, ethernet(packet)},
                          {1, 0, ethernet(Bytes(28, 0), {}, 0x0806)},                 // ARP
                          {1, 0, ethernet(Bytes(30, 0x60), {}, 0x86DD)},              // IPv6
                          {1, 0, ethernet(ipv4(make_payload(40), {.protocol = 6}))},  // TCP
                          {1, 0, ethernet(packet), 1},
                          {1, 0, ethernet(packet), 120},
                          {1, 0, ethernet(packet), 135},
                          {1, 0, ethernet(ipv4(long_udp))},
                          {1, 0, ethernet(ipv4(tiny_udp))},
                          {1, 0, ethernet(long_ip)},
                          {1, 0, ethernet(short_header)},
                          {1, 0, Bytes(9, 0)},
                      }));
  EXPECT_EQ(outcome.counters.packets, 12u);
  EXPECT_EQ(outcome.counters.datagrams, 2u);  // the length of UDP fits where that of IPv4 does not
  EXPECT_EQ(outcome.counters.not_udp, 2u);
  EXPECT_EQ(outcome.counters.truncated, 3u);
  EXPECT_EQ(outcome.counters.malformed, 5u);
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

// Cuts a UDP datagram into fragments of `size` bytes (a multiple of 8).
std::vector<Bytes> make_fragments(const Bytes& datagram, size_t size, uint16_t identification,
                                  uint32_t sender = kSender) {
  std::vector<Bytes> result;
  for (size_t at = 0; at < datagram.size(); at += size) {
    const size_t end = std::min(at + size, datagram.size());
    result.push_back(ethernet(ipv4(Bytes(datagram.begin() + static_cast<ptrdiff_t>(at),
                                         datagram.begin() + static_cast<ptrdiff_t>(end)),
                                   {.sender = sender,
                                    .identification = identification,
                                    .offset = at,
                                    .more = end < datagram.size()})));
  }
  return result;
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

TEST(PcapReader, DropsIncompleteFragmentsOnTimeoutOnEvictionAndAtTheEnd) {
  const auto cut = make_fragments(udp(make_payload(2000)), 1480, 5);
  const PcapOutcome late = read_pcap(pcap(kEthernet, {{1, 0, cut[0]}, {40, 0, cut[1]}}));
  EXPECT_TRUE(late.datagrams.empty());
  EXPECT_EQ(late.counters.fragments_dropped, 2u);

  std::vector<Record> records;
  for (uint16_t id = 0; id < 100; ++id) {
    records.push_back({1, id, make_fragments(udp(make_payload(2000)), 1480, id)[0]});
  }
  records.push_back(
      {2, 0,
       make_fragments(udp(make_payload(2000)), 1480, 99)[1]});  // completes the latest datagram
  records.push_back(
      {2, 0, make_fragments(udp(make_payload(2000)), 1480, 3)[1]});  // its datagram was evicted
  PcapOptions options;
  options.max_fragmented_datagrams = 4;
  const PcapOutcome full = read_pcap(pcap(kEthernet, records), options);
  ASSERT_EQ(full.datagrams.size(), 1u);
  EXPECT_EQ(full.datagrams[0].payload, make_payload(2000));
  EXPECT_EQ(full.counters.fragments_dropped, 100u);
}

TEST(PcapReader, ContradictoryFragmentsAreDropped) {
  const auto fragment = [](size_t length, size_t offset, bool more) {
    return ethernet(
        ipv4(make_payload(length), {.identification = 1, .offset = offset, .more = more}));
  };
  const PcapOutcome outcome =
      read_pcap(pcap(kEthernet, {
                                    {1, 0, fragment(13, 0, true)},         // not a multiple of 8
                                    {1, 0, fragment(1400, 65528, false)},  // beyond 65 535 bytes
                                    {1, 0, fragment(0, 8, true)},
                                    {1, 0, fragment(16, 16, false)},  // ends at 32 …
                                    {1, 0, fragment(16, 32, false)},  // … and at 48
                                }));
  EXPECT_TRUE(outcome.datagrams.empty());
  EXPECT_EQ(outcome.counters.fragments, 5u);
  EXPECT_EQ(outcome.counters.fragments_dropped, 5u);
}

TEST(PcapReader, TruncationAtAnyByteKeepsCompletePacketsAndReportsTheEnd) {
  std::vector<Record> records;
  for (uint32_t i = 0; i < 5; ++i)
    records.push_back({i, 0, ethernet(ipv4(udp(make_payload(20 + i))))});
  const Bytes file = pcap(kEthernet, records);
  std::vector<size_t> starts = {24};
  for (const Record& record : records) starts.push_back(starts.back() + 16 + record.frame.size());
  ASSERT_EQ(starts.back(), file.size());
  for (size_t length = 0; length <= file.size(); ++length) {
    SCOPED_TRACE(length);
    const Bytes cut(file.begin(), file.begin() + static_cast<ptrdiff_t>(length));
    auto reader = PcapReader::from_bytes(cut, "cut.pcap");
    if (length < 24) {
      ASSERT_FALSE(reader);
      EXPECT_THAT(reader.error().message(), HasSubstr("cut.pcap"));
      continue;
    }
    ASSERT_TRUE(reader);
    const PcapOutcome outcome = read_pcap(std::move(*reader));
    const auto whole = static_cast<size_t>(std::upper_bound(starts.begin(), starts.end(), length) -
                                           starts.begin() - 1);
    EXPECT_EQ(outcome.datagrams.size(), whole);
    EXPECT_EQ(outcome.damage.has_value(), starts[whole] != length);
    if (outcome.damage) {
      EXPECT_THAT(outcome.damage->where, HasSubstr("packet " + std::to_string(whole + 1) +
                                                   ", byte " + std::to_string(starts[whole])));
    }
  }
}

TEST(PcapReader, ReadingGoesOnBehindADamagedRecord) {
  const Bytes frame = ethernet(ipv4(udp(make_payload(100))));
  const Bytes whole = pcap(kEthernet, std::vector<Record>(10, {1, 0, frame}));
  const size_t record = 16 + frame.size(), third = 24 + 2 * record;
  for (const bool too_long : {true, false}) {
    Bytes file = whole;
    // A length beyond all others, or one that ends within the packet.
    for (size_t i = 8; i < 12; ++i) file[third + i] = too_long ? 0xFF : uint8_t{0};
    if (!too_long) file[third + 8] = 60;
    auto reader = PcapReader::from_bytes(file, "damaged.pcap");
    ASSERT_TRUE(reader);
    Datagram datagram;
    size_t datagrams = 0;
    while (reader->next(datagram)) datagrams += datagram.payload.size() == 100;
    EXPECT_EQ(datagrams, 9u);
    EXPECT_EQ(reader->counters().skipped_bytes, too_long ? record : record - 16 - 60);
    std::vector<Error> notes;
    reader->append_notes(notes);
    ASSERT_FALSE(notes.empty());
    EXPECT_THAT(notes.back().message(), HasSubstr("bytes are no packets, and were skipped"));
  }
}

TEST(PcapReader, NamesACompressionThatIsNotRead) {
  const Bytes xz = {0xFD, '7', 'z', 'X', 'Z', 0, 0, 4, 0xE6, 0xD6, 0xB4, 0x46, 2, 0};
  const auto reader = PcapReader::from_bytes(xz, "drive.pcap.xz");
  ASSERT_FALSE(reader);
  EXPECT_THAT(reader.error().message(), HasSubstr("unpack it first: unxz"));
}

TEST(PcapReader, RejectsFilesThatAreNotCaptures) {
  const Bytes text = {'h', 'e', 'l', 'l', 'o', ' ', 't', 'h', 'e', 'r', 'e', '.', '.', '.',
                      '.', '.', '.', '.', '.', '.', '.', '.', '.', '.', '.', '.', '.'};
  EXPECT_FALSE(PcapReader::from_bytes(text, "hello.txt"));
  EXPECT_FALSE(PcapReader::from_bytes({}, "nothing"));
  EXPECT_FALSE(PcapReader::open("/does/not/exist.pcap"));
  EXPECT_FALSE(PcapReader::open("/"));
  const auto wifi = PcapReader::from_bytes(pcap_header(105, true), "wifi.pcap");
  ASSERT_FALSE(wifi);
  EXPECT_THAT(wifi.error().message(), HasSubstr("link type 105"));
  PcapOptions options;
  options.max_fragmented_datagrams = 1'000'000;
  EXPECT_FALSE(PcapReader::from_bytes(pcap_header(1, true), "x", options));
}

TEST(PcapReader, MutatedCapturesAreReadToTheEnd) {
  std::vector<Record> records;
  for (const Bytes& frame : make_fragments(udp(make_payload(3000)), 1480, 9))
    records.push_back({1, 0, frame});
  records.push_back({1, 1, ethernet(ipv4(udp(make_payload(60))), {{0x8100, 1}})});
  records.push_back({2, 2, ethernet(ipv4(udp(make_payload(60)))), 4});
  const std::vector<Bytes> originals = {pcap(kEthernet, records), pcapng(kEthernet, records),
                                        pcap(kCooked2, records), pcap(kRaw, records, false)};
  std::mt19937 random(7);
  PcapOptions options;
  options.max_fragmented_datagrams = 2;
  uint64_t packets = 0;
  for (int round = 0; round < 10'000; ++round) {
    Bytes file = originals[static_cast<size_t>(round) % originals.size()];
    const size_t changes = 1 + random() % 8;
    for (size_t i = 0; i < changes; ++i) {
      // Mutates headers more often than payload.
      const size_t range = random() % 2 == 0 ? std::min<size_t>(file.size(), 100) : file.size();
      file[random() % range] = static_cast<uint8_t>(random());
    }
    if (random() % 4 == 0) file.resize(1 + random() % file.size());
    auto reader = PcapReader::from_bytes(file, "mutated", options);
    if (!reader) continue;
    Datagram datagram;
    while (reader->next(datagram)) ASSERT_LE(datagram.payload.size(), 65507u);
    const PcapCounters& counters = reader->counters();
    ASSERT_LE(counters.fragments_dropped, counters.fragments);
    ASSERT_LE(counters.datagrams + counters.filtered + counters.not_udp + counters.truncated +
                  counters.malformed,
              counters.packets);
    packets += counters.packets;
  }
  EXPECT_GT(packets, 10'000u);
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

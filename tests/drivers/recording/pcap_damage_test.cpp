#include "drivers/recording/pcap_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/drivers/recording/capture_bytes.hpp"
#include "tests/drivers/recording/read_pcap.hpp"

namespace infuse::recording {
namespace {

using namespace testing;
using ::testing::HasSubstr;

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

}  // namespace
}  // namespace infuse::recording

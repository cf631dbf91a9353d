// Captures compressed by gzip and zstd give the same datagrams as uncompressed ones.

#include <gtest/gtest.h>

#include <random>

#include "drivers/recording/pcap_reader.hpp"
#include "tests/drivers/recording/compress.hpp"

namespace infuse::recording {
namespace {

using testing::Bytes;
using namespace testing;

/// Several hundred datagrams of random payload: more than the buffers hold.
Bytes make_capture() {
  std::mt19937 random(1);
  std::vector<Record> records;
  for (uint32_t i = 0; i < 400; ++i) {
    Bytes payload(1206);
    for (uint8_t& byte : payload) byte = static_cast<uint8_t>(random());
    records.push_back({1, i, ethernet(ipv4(udp(payload)))});
  }
  return pcap(kEthernet, records);
}

struct Outcome {
  std::vector<Bytes> payloads;
  bool opened = false;
  bool damaged = false;
};

Outcome read_all(const Bytes& file) {
  Outcome outcome;
  auto reader = PcapReader::from_bytes(file, "x.pcap");
  if (!reader) return outcome;
  outcome.opened = true;
  Datagram datagram;
  while (reader->next(datagram)) {
    outcome.payloads.emplace_back(datagram.payload.begin(), datagram.payload.end());
  }
  outcome.damaged = reader->damage().has_value();
  return outcome;
}

TEST(CompressedCapture, GivesTheSameDatagrams) {
  const Bytes plain = make_capture();
  const Outcome expected = read_all(plain);
  ASSERT_EQ(expected.payloads.size(), 400U);
  for (const Bytes& file : {gzip(plain), zstd(plain)}) {
    const Outcome outcome = read_all(file);
    EXPECT_FALSE(outcome.damaged);
    EXPECT_EQ(outcome.payloads, expected.payloads);
  }
}

TEST(CompressedCapture, MembersAreReadOneAfterTheOther) {
  const Bytes plain = make_capture();
  const auto middle = plain.begin() + 100'000;
  for (auto* compress : {gzip, zstd}) {
    Bytes file = compress({plain.begin(), middle});
    add(file, compress({middle, plain.end()}));
    const Outcome outcome = read_all(file);
    EXPECT_FALSE(outcome.damaged);
    EXPECT_EQ(outcome.payloads.size(), 400U);
  }
}

TEST(CompressedCapture, WhatIsCutOrDamagedEndsWithANote) {
  const Bytes plain = make_capture();
  for (const Bytes& file : {gzip(plain), zstd(plain)}) {
    const Outcome cut = read_all({file.begin(), file.begin() + static_cast<long>(file.size() / 2)});
    EXPECT_TRUE(cut.damaged);
    EXPECT_GT(cut.payloads.size(), 100U);
    EXPECT_LT(cut.payloads.size(), 400U);
    std::mt19937 random(2);
    for (int i = 0; i < 50; ++i) {
      Bytes damaged = file;
      for (int k = 0; k < 8; ++k) damaged[random() % 2000] = static_cast<uint8_t>(random());
      const Outcome outcome = read_all(damaged);
      EXPECT_LE(outcome.payloads.size(), 400U);
    }
  }
  EXPECT_FALSE(read_all({0x1F, 0x8B}).opened);
  EXPECT_FALSE(read_all({0x28, 0xB5, 0x2F, 0xFD}).opened);
}

}  // namespace
}  // namespace infuse::recording

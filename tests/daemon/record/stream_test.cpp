#include <gtest/gtest.h>

#include <random>

#include "daemon/record/record_parser.hpp"
#include "daemon/record/record_tap.hpp"

namespace infuse::daemon {
namespace {

RecordChunk new_chunk() {
  RecordChunk chunk;
  chunk.bytes.reserve(RecordChunk::kMaxBytes);
  return chunk;
}

/// A datagram whose payload is a function of its number.
std::vector<uint8_t> payload_of(uint64_t number) {
  std::mt19937_64 random(number);
  std::vector<uint8_t> payload(random() % 2000);
  for (uint8_t& byte : payload) byte = static_cast<uint8_t>(random());
  return payload;
}

void add_datagram(RecordTap& tap, uint64_t number) {
  const std::vector<uint8_t> payload = payload_of(number);
  tap.add_datagram(
      Datagram{Stamp::from_ns(static_cast<int64_t>(number)), 0x7F000001, 1234, 2368, payload});
}

/// Checks a record against the datagram of its stamp.
void check_record(const Record& record) {
  const std::vector<uint8_t> payload = payload_of(static_cast<uint64_t>(record.header.stamp_ns));
  ASSERT_EQ(record.header.kind, RecordKind::kDatagram);
  ASSERT_EQ(record.body.size(), sizeof(DatagramHeader) + payload.size());
  DatagramHeader header;
  std::memcpy(&header, record.body.data(), sizeof(header));
  EXPECT_EQ(header.sender, 0x7F000001U);
  EXPECT_EQ(header.sender_port, 1234);
  EXPECT_EQ(header.destination_port, 2368);
  EXPECT_TRUE(std::equal(payload.begin(), payload.end(), record.body.begin() + sizeof(header)));
}

TEST(RecordStream, AllRecordsComeBackInOrder) {
  RecordRing ring(64, new_chunk);
  auto reader = ring.make_reader();
  RecordTap tap(ring);
  tap.set_enabled(true);
  constexpr uint64_t kRecords = 5000;  // 5 MB, 20 chunks
  for (uint64_t i = 0; i < kRecords; ++i) add_datagram(tap, i);
  tap.finish();
  RecordParser parser;
  uint64_t next = 0;
  while (const auto chunk = reader.next()) {
    parser.parse(*chunk, [&](const Record& record) {
      EXPECT_EQ(record.header.stamp_ns, static_cast<int64_t>(next++));
      check_record(record);
    });
  }
  EXPECT_EQ(next, kRecords);
  EXPECT_EQ(parser.lost(), 0U);
}

TEST(RecordStream, OverwrittenRecordsAreCountedAndTheOthersAreComplete) {
  RecordRing ring(8, new_chunk);
  auto reader = ring.make_reader();
  RecordTap tap(ring);
  tap.set_enabled(true);
  RecordParser parser;
  uint64_t read = 0, first = 0, last = 0;
  const auto read_some = [&](int chunks) {
    for (int i = 0; i < chunks; ++i) {
      const auto chunk = reader.next();
      if (!chunk) return;
      parser.parse(*chunk, [&](const Record& record) {
        check_record(record);
        const auto number = static_cast<uint64_t>(record.header.stamp_ns);
        if (read++ == 0) first = number;
        EXPECT_TRUE(read == 1 || number > last);
        last = number;
      });
    }
  };
  std::mt19937_64 random(7);
  uint64_t put_so_far = 0;
  for (int round = 0; round < 30; ++round) {  // up to 16 chunks between reads; the ring holds 8
    for (uint64_t n = random() % 4000; n > 0; --n) add_datagram(tap, put_so_far++);
    read_some(3);
  }
  tap.finish();
  read_some(100);
  EXPECT_EQ(last, put_so_far - 1);
  EXPECT_GT(parser.lost(), 1000U);
  EXPECT_EQ(read + parser.lost(), last - first + 1);
}

TEST(RecordStream, ARecordLargerThanAChunkContinuesInTheNext) {
  RecordRing ring(64, new_chunk);
  auto reader = ring.make_reader();
  RecordTap tap(ring);
  tap.set_enabled(true);
  std::vector<uint8_t> pixels(3 * RecordChunk::kMaxBytes + 17);
  for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<uint8_t>(i * 7);
  camera::StreamedImage image;
  image.sequence = 9;
  image.raw.bytes = pixels;
  add_datagram(tap, 1);
  tap.add_image(3, image);
  add_datagram(tap, 2);
  tap.finish();
  RecordParser parser;
  std::vector<RecordKind> kinds;
  while (const auto chunk = reader.next()) {
    parser.parse(*chunk, [&](const Record& record) {
      kinds.push_back(record.header.kind);
      if (record.header.kind != RecordKind::kImage) return check_record(record);
      EXPECT_EQ(record.header.source, 3U);
      const auto body = record.body.subspan(sizeof(ImageHeader));
      EXPECT_TRUE(std::equal(body.begin(), body.end(), pixels.begin(), pixels.end()));
    });
  }
  EXPECT_EQ(kinds, (std::vector{RecordKind::kDatagram, RecordKind::kImage, RecordKind::kDatagram}));
}

TEST(RecordStream, NothingIsKeptWhileDisabled) {
  RecordRing ring(4, new_chunk);
  RecordTap tap(ring);
  add_datagram(tap, 1);
  tap.finish();
  EXPECT_EQ(ring.published(), 0U);
}

TEST(RecordStream, APartialChunkIsPushedAtItsMaximumAge) {
  RecordRing ring(4, new_chunk);
  RecordTap tap(ring);
  tap.set_enabled(true);
  const Stamp start = Stamp::from_ns(1'000'000'000);
  tap.flush_if_due(start);
  add_datagram(tap, 1);
  tap.flush_if_due(start + RecordTap::kMaxChunkAge / 2);
  EXPECT_EQ(ring.published(), 0U);
  tap.flush_if_due(start + RecordTap::kMaxChunkAge);
  EXPECT_EQ(ring.published(), 1U);
}

}  // namespace
}  // namespace infuse::daemon

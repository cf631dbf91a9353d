#include <gtest/gtest.h>

#include <random>

#include "drivers/mcap/mcap_reader.hpp"
#include "drivers/mcap/mcap_writer.hpp"
#include "drivers/mcap/record_bytes.hpp"
#include "drivers/recording/mapped_file.hpp"
#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::mcap {
namespace {

using Bytes = std::vector<uint8_t>;

struct Stored {
  uint16_t channel;
  int64_t log_time;
  Bytes data;
  bool operator==(const Stored&) const = default;
};

const Channel kImu = {"/imu", "cdr", {"sensor_msgs/msg/Imu", "ros2msg", "int8 a"}, {{"qos", "x"}}};
const Channel kOther = {"/other", "json", {}, {}};
const Channel kImuRear = {"/rear", "cdr", kImu.schema, {}};

// Messages 0.1 s apart on three channels, of random length and compressible content.
std::vector<Stored> make_messages(size_t count) {
  std::mt19937 random(7);
  std::vector<Stored> messages;
  for (size_t k = 0; k < count; ++k) {
    const size_t length = random() % 300;
    messages.push_back({static_cast<uint16_t>(k % 3), static_cast<int64_t>(k) * 100'000'000,
                        Bytes(length, static_cast<uint8_t>(k))});
  }
  return messages;
}

Bytes write_file(const std::vector<Stored>& messages, Compression compression) {
  const ScratchFolder folder;
  auto writer = McapWriter::create(folder / "a.mcap", {.compression = compression});
  EXPECT_TRUE(writer);
  EXPECT_EQ(writer->add_channel(kImu), uint16_t{0});
  EXPECT_EQ(writer->add_channel(kOther), uint16_t{1});
  EXPECT_EQ(writer->add_channel(kImuRear), uint16_t{2});
  EXPECT_TRUE(writer->write_metadata("rig", {{"lidar", "top"}}));
  for (const Stored& message : messages) {
    const Stamp stamp = Stamp::from_ns(message.log_time);
    EXPECT_TRUE(writer->write(message.channel, stamp, stamp, message.data));
  }
  EXPECT_TRUE(writer->close());
  const std::string text = folder.read("a.mcap");
  return {text.begin(), text.end()};
}

struct ReadBack {
  std::vector<Stored> messages;
  ReaderCounters counters;
  std::vector<Error> notes;
  bool complete = false;
};

ReadBack read_file(const Bytes& bytes) {
  ReadBack read;
  auto reader = McapReader::open(bytes, "a.mcap");
  if (!reader) return read;
  Message message;
  while (reader->next(message)) {
    read.messages.push_back({message.channel_id, message.log_time.ns(),
                             Bytes(message.data.begin(), message.data.end())});
  }
  read.counters = reader->counters();
  reader->append_notes(read.notes);
  read.complete = reader->is_complete();
  return read;
}

// Position and content length of each record of the file outside chunks.
struct Place {
  Opcode opcode;
  size_t content, length;
};
std::vector<Place> find_records(const Bytes& bytes) {
  std::vector<Place> places;
  size_t at = kMagic.size();
  while (at + kRecordHeader < bytes.size()) {
    uint64_t length = 0;
    std::memcpy(&length, &bytes[at + 1], 8);
    places.push_back({static_cast<Opcode>(bytes[at]), at + kRecordHeader, length});
    at += kRecordHeader + length;
  }
  return places;
}

class McapCompressions : public testing::TestWithParam<Compression> {};

TEST_P(McapCompressions, WhatIsWrittenIsRead) {
  const auto messages = make_messages(100);
  const ReadBack read = read_file(write_file(messages, GetParam()));
  EXPECT_EQ(read.messages, messages);
  EXPECT_TRUE(read.complete);
  EXPECT_TRUE(read.notes.empty()) << read.notes.front().message();
  EXPECT_EQ(read.counters.chunks, 10u);  // 11 messages in each closed second
}

TEST_P(McapCompressions, FileThatIsCutIsReadUpToItsLastWholeChunk) {
  const auto messages = make_messages(100);
  const Bytes whole = write_file(messages, GetParam());
  for (size_t length = 0; length < whole.size(); length += 13) {
    const ReadBack read =
        read_file(Bytes(whole.begin(), whole.begin() + static_cast<long>(length)));
    ASSERT_LE(read.messages.size(), messages.size());
    EXPECT_TRUE(std::equal(read.messages.begin(), read.messages.end(), messages.begin()));
    EXPECT_FALSE(read.complete);
    EXPECT_EQ(read.counters.damaged_chunks, 0u);
  }
}

TEST_P(McapCompressions, DamagedChunkIsSkippedAndCounted) {
  const auto messages = make_messages(100);
  Bytes bytes = write_file(messages, GetParam());
  size_t seen = 0;
  for (const Place& record : find_records(bytes)) {
    if (record.opcode == Opcode::kChunk && ++seen == 3) {
      bytes[record.content + record.length - 5] ^= 0x10;
    }
  }
  const ReadBack read = read_file(bytes);
  EXPECT_EQ(read.counters.damaged_chunks, 1u);
  EXPECT_EQ(read.messages.size(), 89u);
  EXPECT_EQ(read.notes.size(), 3u);  // the chunk, the CRC of the data, the count
}

INSTANTIATE_TEST_SUITE_P(All, McapCompressions,
                         testing::Values(Compression::kNone, Compression::kLz4,
                                         Compression::kZstd));

TEST(Mcap, ChannelsKeepSchemaAndMetadata) {
  const Bytes bytes = write_file(make_messages(3), Compression::kZstd);
  auto reader = McapReader::open(bytes, "a.mcap");
  ASSERT_TRUE(reader);
  Message message;
  for (const Channel* expected : {&kImu, &kOther, &kImuRear}) {
    ASSERT_TRUE(reader->next(message));
    EXPECT_EQ(*message.channel, *expected);
  }
  EXPECT_FALSE(reader->next(message));
  EXPECT_EQ(reader->metadata().at("rig").at("lidar"), "top");
}

// An indexed reader finds every message by the index entries, which count from the file's begin.
TEST(Mcap, IndexesPointToTheirMessages) {
  const auto messages = make_messages(100);
  const Bytes bytes = write_file(messages, Compression::kNone);
  size_t indexed = 0;
  const Place* chunk = nullptr;
  const auto records = find_records(bytes);
  for (const Place& record : records) {
    if (record.opcode == Opcode::kChunk) chunk = &record;
    if (record.opcode != Opcode::kMessageIndex) continue;
    ASSERT_NE(chunk, nullptr);
    FieldReader fields(std::span<const uint8_t>(bytes).subspan(record.content, record.length));
    const auto channel = fields.number<uint16_t>();
    const auto count = fields.number<uint32_t>() / 16;
    for (uint32_t k = 0; k < count; ++k) {
      const auto time = fields.number<uint64_t>();
      const auto offset = fields.number<uint64_t>();
      constexpr size_t kChunkFields = 8 + 8 + 8 + 4 + 4 + 8;
      FieldReader message(
          std::span<const uint8_t>(bytes).subspan(chunk->content + kChunkFields + offset));
      EXPECT_EQ(message.number<Opcode>(), Opcode::kMessage);
      message.number<uint64_t>();
      EXPECT_EQ(message.number<uint16_t>(), channel);
      message.number<uint32_t>();
      EXPECT_EQ(message.number<uint64_t>(), time);
      ++indexed;
    }
  }
  EXPECT_EQ(indexed, messages.size());
}

TEST(Mcap, ChunksSpanAtMostASecond) {
  const Bytes bytes = write_file(make_messages(100), Compression::kNone);
  for (const Place& record : find_records(bytes)) {
    if (record.opcode != Opcode::kChunk) continue;
    FieldReader fields(std::span<const uint8_t>(bytes).subspan(record.content, record.length));
    const auto first = fields.number<uint64_t>();
    EXPECT_LE(fields.number<uint64_t>() - first, 1'000'000'000u);
  }
}

TEST(Mcap, UnknownRecordsAreSkippedAndCounted) {
  const auto messages = make_messages(10);
  Bytes bytes = write_file(messages, Compression::kNone);
  const Bytes unknown = {0x80, 3, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3};
  const size_t after_header = find_records(bytes)[1].content - kRecordHeader;
  bytes.insert(bytes.begin() + static_cast<long>(after_header), unknown.begin(), unknown.end());
  const ReadBack read = read_file(bytes);
  EXPECT_EQ(read.messages, messages);
  EXPECT_EQ(read.counters.unknown_records, 1u);
}

TEST(Mcap, WritingIsRefusedWhereTheFormatCannotSayIt) {
  const ScratchFolder folder;
  EXPECT_FALSE(McapWriter::create(folder / "none/a.mcap"));
  EXPECT_FALSE(McapWriter::create(folder / "a.mcap", {.chunk_span = Duration(0)}));
  auto writer = McapWriter::create(folder / "a.mcap");
  ASSERT_TRUE(writer);
  EXPECT_FALSE(writer->write(0, Stamp(), Stamp(), {}));  // no such channel
  ASSERT_TRUE(writer->add_channel(kImu));
  EXPECT_FALSE(writer->write(0, Stamp::from_ns(-1), Stamp(), {}));
  EXPECT_TRUE(writer->close());
  EXPECT_FALSE(writer->write(0, Stamp(), Stamp(), {}) && writer->close());
}

TEST(Mcap, ClaimedSizesDoNotBecomeMemory) {
  Bytes out;
  EXPECT_FALSE(decompress_chunk(Compression::kZstd, {}, uint64_t{1} << 60, out));
  EXPECT_FALSE(decompress_chunk(Compression::kLz4, Bytes{4, 34, 77}, kMaxChunkBytes, out));
  EXPECT_LT(out.capacity(), size_t{8} << 20);
}

TEST(Mcap, OtherFilesAreErrors) {
  EXPECT_FALSE(McapReader::open({}, "a"));
  EXPECT_FALSE(McapReader::open(Bytes(100, 0), "a"));
}

TEST(Mcap, MutatedFilesNeitherCrashNorHang) {
  std::mt19937 random(1);
  const auto messages = make_messages(25);
  size_t read_messages = 0;
  for (const auto compression : {Compression::kNone, Compression::kLz4, Compression::kZstd}) {
    const Bytes sound = write_file(messages, compression);
    for (int k = 0; k < 3400; ++k) {
      Bytes bytes = sound;
      for (unsigned n = 1 + random() % 4; n > 0; --n) {
        const size_t at = random() % bytes.size();
        switch (random() % 3) {
          case 0:
            bytes[at] = static_cast<uint8_t>(random());
            break;
          case 1:
            bytes.erase(bytes.begin() + static_cast<long>(at));
            break;
          default:
            bytes.insert(bytes.begin() + static_cast<long>(at), static_cast<uint8_t>(random()));
        }
      }
      const ReadBack read = read_file(bytes);
      ASSERT_LE(read.messages.size(), 2 * messages.size());
      read_messages += read.messages.size();
    }
  }
  EXPECT_GT(read_messages, 3u * 3400u);  // what can be read is read
}

TEST(Mcap, RealRosbagIsReadWhole) {
  INFUSE_REAL_DATA_OR_SKIP(path, "formats/mcap/evo_kiss_0_0.mcap");
  const auto file = recording::MappedFile::open(path);
  ASSERT_TRUE(file);
  const auto bytes = file->bytes();
  auto reader = McapReader::open({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()},
                                 path.string());
  ASSERT_TRUE(reader);
  Message message;
  std::map<std::string, size_t> topics;
  while (reader->next(message)) ++topics[message.channel->topic];
  EXPECT_TRUE(reader->is_complete());
  EXPECT_EQ(reader->counters().messages, 11468u);  // as its metadata.yaml states
  EXPECT_EQ(topics.size(), 3u);
  EXPECT_EQ(reader->counters().chunks, 2u);
}

}  // namespace
}  // namespace infuse::mcap

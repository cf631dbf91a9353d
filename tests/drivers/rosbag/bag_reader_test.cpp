#include "drivers/rosbag/bag_reader.hpp"

#include <bzlib.h>
#include <gtest/gtest.h>

#include <random>

#include "tests/drivers/rosbag/bag_bytes.hpp"

namespace infuse::rosbag {
namespace {

struct Stored {
  std::string topic;
  int64_t time;
  std::string data;
  bool operator==(const Stored&) const = default;
};

std::vector<Stored> read_all(const std::string& bytes, BagCounters* counters = nullptr,
                             std::vector<Error>* notes = nullptr) {
  std::vector<Stored> messages;
  auto reader =
      BagReader::open({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, "a.bag");
  if (!reader) return messages;
  BagMessage message;
  while (reader->next(message)) {
    messages.push_back({message.connection->topic, message.time.ns(),
                        std::string(message.data.begin(), message.data.end())});
  }
  if (counters != nullptr) *counters = reader->counters();
  if (notes != nullptr) reader->append_notes(*notes);
  return messages;
}

std::string make_bag(const std::string& compression) {
  BagBytes bag;
  for (int chunk = 0; chunk < 4; ++chunk) {
    std::string content = bag.connection(0, "/imu", "sensor_msgs/Imu");
    content += bag.connection(1, "/scan", "velodyne_msgs/VelodyneScan");
    for (uint32_t k = 0; k < 5; ++k) {
      const uint32_t second = 1'700'000'000 + static_cast<uint32_t>(chunk) * 5 + k;
      content += bag.message(k % 2, second, k, std::string(k * 40, static_cast<char>('a' + chunk)));
    }
    bag.add_chunk(compression, content);
  }
  return bag.bytes();
}

class BagCompressions : public testing::TestWithParam<const char*> {};

TEST_P(BagCompressions, MessagesAreReadInTheirOrder) {
  std::vector<Error> notes;
  const auto messages = read_all(make_bag(GetParam()), nullptr, &notes);
  ASSERT_EQ(messages.size(), 20u);
  for (size_t i = 0; i < messages.size(); ++i) {
    const size_t k = i % 5;
    EXPECT_EQ(messages[i].topic, k % 2 == 0 ? "/imu" : "/scan");
    EXPECT_EQ(messages[i].time,
              (1'700'000'000 + static_cast<int64_t>(i)) * 1'000'000'000 + static_cast<int64_t>(k));
    EXPECT_EQ(messages[i].data, std::string(k * 40, static_cast<char>('a' + i / 5)));
  }
  EXPECT_TRUE(notes.empty());
}

TEST_P(BagCompressions, BagThatIsCutIsReadUpToItsLastWholeChunk) {
  const std::string whole = make_bag(GetParam());
  const auto messages = read_all(whole);
  for (size_t length = 0; length < whole.size(); length += 7) {
    const auto read = read_all(whole.substr(0, length));
    ASSERT_EQ(read.size() % 5, 0u);
    EXPECT_TRUE(std::equal(read.begin(), read.end(), messages.begin()));
  }
}

TEST_P(BagCompressions, MutatedBagsNeitherCrashNorHang) {
  std::mt19937 random(2);
  const std::string sound = make_bag(GetParam());
  size_t messages = 0;
  for (int k = 0; k < 3400; ++k) {
    std::string bytes = sound;
    for (size_t n = 1 + random() % 3; n > 0; --n) {
      const size_t at = random() % bytes.size();
      switch (random() % 3) {
        case 0:
          bytes[at] = static_cast<char>(random());
          break;
        case 1:
          bytes.erase(at, 1);
          break;
        default:
          bytes.insert(at, 1, static_cast<char>(random()));
      }
    }
    const size_t read = read_all(bytes).size();
    ASSERT_LE(read, 40u);
    messages += read;
  }
  EXPECT_GT(messages, 3400u);  // what can be read is read
}

INSTANTIATE_TEST_SUITE_P(All, BagCompressions, testing::Values("none", "bz2", "lz4"));

TEST(BagReader, WhatCannotBeReadIsCounted) {
  BagBytes bag;
  bag.add_chunk("xz", bag.connection(0, "/a", "b/C"));
  bag.add_chunk("none", bag.message(7, 1, 2, "x"));
  BagCounters counters;
  EXPECT_TRUE(read_all(bag.bytes(), &counters).empty());
  EXPECT_EQ(counters.damaged_chunks, 1u);
  EXPECT_EQ(counters.without_connection, 1u);
}

TEST(BagReader, EncryptedBagsAndOtherFilesAreErrors) {
  const auto open = [](const std::string& text) {
    return BagReader::open({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, "a.bag");
  };
  EXPECT_TRUE(open(BagBytes().bytes()));
  EXPECT_FALSE(open(BagBytes("rosbag/AesCbcEncryptor").bytes()));
  EXPECT_FALSE(open("#ROSBAG V1.2\n"));
  EXPECT_FALSE(open(""));
}

}  // namespace
}  // namespace infuse::rosbag

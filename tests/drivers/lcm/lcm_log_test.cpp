#include "drivers/lcm/lcm_log.hpp"

#include <gtest/gtest.h>

#include <random>

#include "drivers/text/text_file.hpp"
#include "tests/drivers/lcm/lcm_bytes.hpp"
#include "tests/real_data.hpp"

namespace infuse::lcm {
namespace {

constexpr uint64_t kStartUs = 1'700'000'000'000'000;

struct StoredEvent {
  uint64_t number;
  int64_t time;
  std::string channel, data;
  bool operator==(const StoredEvent&) const = default;
};

struct ReadLog {
  std::vector<StoredEvent> events;
  LcmCounters counters;
  std::vector<Error> notes;
};

ReadLog read_log(const std::string& bytes) {
  ReadLog log;
  auto reader =
      LcmReader::open({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, "a.lcm");
  if (!reader) return log;
  LcmEvent event;
  while (reader->next(event)) {
    log.events.push_back({event.number, event.time.ns(), std::string(event.channel),
                          std::string(event.data.begin(), event.data.end())});
  }
  log.counters = reader->counters();
  reader->append_notes(log.notes);
  return log;
}

StoredEvent expected_event(uint64_t k) {
  return {k, static_cast<int64_t>(kStartUs + 1000 * k) * 1000, k % 2 == 0 ? "POSE" : "VELODYNE",
          std::string(10 * k, static_cast<char>('a' + k))};
}

std::string event_bytes(uint64_t k) {
  const auto [number, time, channel, data] = expected_event(k);
  return make_event(number, kStartUs + 1000 * k, channel, data);
}

std::string make_log(uint64_t events) {
  std::string bytes;
  for (uint64_t k = 0; k < events; ++k) bytes += event_bytes(k);
  return bytes;
}

TEST(LcmLog, EventsAreReadInTheirOrder) {
  const ReadLog log = read_log(make_log(6));
  ASSERT_EQ(log.events.size(), 6u);
  for (uint64_t k = 0; k < 6; ++k) EXPECT_EQ(log.events[k], expected_event(k));
  EXPECT_TRUE(log.notes.empty());
}

TEST(LcmLog, DamagedBytesBetweenEventsAreSkippedAndCounted) {
  const std::string log = make_log(3);
  const ReadLog damaged =
      read_log(log + std::string("\xED\xA1\xDA\x01 no event", 13) + event_bytes(5));
  ASSERT_EQ(damaged.events.size(), 4u);
  EXPECT_EQ(damaged.events[3], expected_event(5));
  EXPECT_EQ(damaged.counters.damaged_places, 1u);
  EXPECT_EQ(damaged.counters.skipped_bytes, 13u);
  EXPECT_EQ(damaged.counters.missing_events, 2u);  // 3 and 4
  ASSERT_EQ(damaged.notes.size(), 1u);
  EXPECT_NE(damaged.notes[0].what.find("at byte " + std::to_string(log.size())), std::string::npos);
}

// A bit that flips in the length of event 1 makes it cover others; one in its sync word loses it.
TEST(LcmLog, OneDamagedEventCostsNoOthers) {
  const size_t begin = event_bytes(0).size();
  for (const auto& [offset, value] : std::vector<std::pair<size_t, char>>{
           {26, '\x00'}, {27, '\x21'}, {25, '\x7F'}, {24, '\xFF'}, {0, 'x'}, {22, '\x70'}}) {
    std::string bytes = make_log(40);
    if (bytes[begin + offset] == value) continue;
    bytes[begin + offset] = value;
    const ReadLog log = read_log(bytes);
    ASSERT_EQ(log.events.size(), 39u) << offset;
    EXPECT_EQ(log.events[0], expected_event(0)) << offset;
    for (uint64_t k = 2; k < 40; ++k) EXPECT_EQ(log.events[k - 1], expected_event(k)) << offset;
    EXPECT_EQ(log.counters.missing_events, 1u) << offset;
  }
}

TEST(LcmLog, LogWithinALogIsOneMessage) {
  const std::string inner = make_log(5);
  const ReadLog log = read_log(make_event(0, 1, "LOG", inner) + event_bytes(1));
  ASSERT_EQ(log.events.size(), 2u);
  EXPECT_EQ(log.events[0].data, inner);
}

TEST(LcmLog, CutLogIsReadUpToItsLastWholeEvent) {
  const std::string bytes = make_log(5);
  const size_t whole = make_log(4).size();
  for (size_t size = whole + 1; size < bytes.size(); ++size) {
    const ReadLog log = read_log(bytes.substr(0, size));
    ASSERT_EQ(log.events.size(), 4u) << size;
    ASSERT_EQ(log.notes.size(), 1u) << size;
    EXPECT_EQ(log.counters.skipped_bytes, size - whole);
  }
  EXPECT_TRUE(read_log(bytes.substr(0, whole)).notes.empty());
}

TEST(LcmLog, OtherFilesAreRefused) {
  for (const std::string bytes : {"", "a", "#ROSBAG V2.0\n", "\xED\xA1\xDA\x01"}) {
    const auto reader =
        LcmReader::open({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()}, "a.lcm");
    ASSERT_FALSE(reader);
    EXPECT_EQ(reader.error().where, "a.lcm");
  }
}

TEST(LcmLog, RealLogIsReadWhole) {
  INFUSE_REAL_DATA_OR_SKIP(path, "formats/lcm/example.lcmlog");
  const auto bytes = text::read_text(path, 1 << 20);
  ASSERT_TRUE(bytes);
  const ReadLog log = read_log(*bytes);
  ASSERT_EQ(log.events.size(), 10u);
  EXPECT_TRUE(log.notes.empty());
  for (size_t k = 0; k < 10; ++k) {
    EXPECT_EQ(log.events[k].number, k);
    EXPECT_EQ(log.events[k].channel, "JOINT_TEST");
    EXPECT_EQ(log.events[k].data.size(), 366u);
  }
}

// Every byte is of an event or counted as skipped; what is read keeps its bytes.
TEST(LcmLog, TenThousandMutatedLogsAreReadAsFarAsPossible) {
  const std::string sound = make_log(12);
  std::mt19937 random(5);
  size_t events = 0;
  for (int k = 0; k < 10'000; ++k) {
    std::string bytes = sound;
    for (size_t n = 1 + random() % 3; n > 0; --n) {
      const size_t at = random() % bytes.size();
      switch (random() % 3) {
        case 0:
          bytes[at] = static_cast<char>(random());
          break;
        case 1:
          bytes.erase(at, random() % 50);
          break;
        default:
          bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 50));
      }
      if (bytes.empty()) bytes = "x";
    }
    const ReadLog log = read_log(bytes);
    if (log.events.empty()) continue;
    events += log.events.size();
    size_t size = log.counters.skipped_bytes;
    for (const StoredEvent& event : log.events)
      size += 28 + event.channel.size() + event.data.size();
    ASSERT_EQ(size, bytes.size());
    ASSERT_EQ(log.notes.empty(), log.counters.skipped_bytes == 0);
  }
  EXPECT_GT(events, 90'000u);  // of 120 000; each damage costs an event or two
}

}  // namespace
}  // namespace infuse::lcm

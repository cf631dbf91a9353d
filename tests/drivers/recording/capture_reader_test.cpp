// A recording in several files gives the datagrams of the recording in one.

#include "drivers/recording/capture_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>

#include "drivers/recording/capture_parts.hpp"
#include "tests/drivers/recording/capture_bytes.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

namespace fs = std::filesystem;
using testing::Bytes;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::Record;

void write(const fs::path& path, const Bytes& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

/// Datagram `number` of a recording with one datagram a millisecond from 1000 s on.
Record record(uint32_t number) {
  return {1000 + number / 1000, number % 1000 * 1'000'000,
          testing::ethernet(testing::ipv4(testing::udp(testing::make_payload(64, number))))};
}

void write_part(const fs::path& path, uint32_t begin, uint32_t end) {
  std::vector<Record> records;
  for (uint32_t i = begin; i < end; ++i) records.push_back(record(i));
  write(path, testing::pcap(testing::kEthernet, records));
}

struct Reading {
  std::vector<uint32_t> numbers;  ///< by stamp
  std::string notes;
  PcapCounters counters;
  size_t parts = 0;
};

Reading read(const fs::path& path, const PcapOptions& options = {}) {
  Reading reading;
  auto reader = CaptureReader::open(path, options);
  if (!reader) {
    reading.notes = reader.error().message();
    return reading;
  }
  Datagram datagram;
  while (reader->next(datagram)) {
    const auto number = static_cast<uint32_t>(datagram.stamp.ns() / 1'000'000 - int64_t{1'000'000});
    const Bytes expected = testing::make_payload(64, number);
    EXPECT_TRUE(std::ranges::equal(datagram.payload, expected));
    reading.numbers.push_back(number);
  }
  std::vector<Error> notes;
  reader->append_notes(notes);
  for (const Error& note : notes) reading.notes += note.message() + "\n";
  reading.counters = reader->counters();
  reading.parts = reader->parts();
  return reading;
}

std::vector<uint32_t> range(uint32_t begin, uint32_t end) {
  std::vector<uint32_t> numbers;
  for (uint32_t i = begin; i < end; ++i) numbers.push_back(i);
  return numbers;
}

std::vector<std::string> names(const std::vector<fs::path>& paths) {
  std::vector<std::string> list;
  for (const fs::path& path : paths) list.push_back(path.filename());
  return list;
}

TEST(CaptureParts, TheFirstNumberedFileNamesAll) {
  const ScratchFolder folder;
  for (const char* name :
       {"a.pcap", "a.pcap1", "a.pcap2", "a.pcap10", "b.pcap00", "b.pcap01", "c.pcap", "c.pcap.gz",
        "d_00007_20260101120000.pcapng", "d_00008_20260101120100.pcapng", "e.pcap.gz", "e.pcap1.gz",
        "notes.txt", "f-120000.pcap", "f-120100.pcap"}) {
    write(folder / name, {});
  }
  const auto parts = [&](const char* name) { return names(*find_capture_parts(folder / name)); };
  EXPECT_THAT(parts("a.pcap"), ElementsAre("a.pcap", "a.pcap1", "a.pcap2", "a.pcap10"));
  EXPECT_THAT(parts("a.pcap2"), ElementsAre("a.pcap2"));
  EXPECT_THAT(parts("b.pcap00"), ElementsAre("b.pcap00", "b.pcap01"));
  EXPECT_THAT(parts("c.pcap"), ElementsAre("c.pcap"));
  EXPECT_THAT(parts("d_00007_20260101120000.pcapng"),
              ElementsAre("d_00007_20260101120000.pcapng", "d_00008_20260101120100.pcapng"));
  EXPECT_THAT(parts("e.pcap.gz"), ElementsAre("e.pcap.gz", "e.pcap1.gz"));
  EXPECT_THAT(parts("f-*.pcap"), ElementsAre("f-120000.pcap", "f-120100.pcap"));
  EXPECT_THAT(parts("nothing.pcap"), ElementsAre("nothing.pcap"));
  EXPECT_FALSE(find_capture_parts(folder / "g*.pcap"));
  EXPECT_EQ(find_capture_parts(folder.path())->size(), 14U);
  EXPECT_THAT(
      names(list_captures(folder.path())),
      ElementsAre("a.pcap", "b.pcap00", "c.pcap", "c.pcap.gz", "d_00007_20260101120000.pcapng",
                  "e.pcap.gz", "f-120000.pcap", "f-120100.pcap"));
}

TEST(CaptureReader, PartsAtAnyPacketGiveTheWholeRecording) {
  std::mt19937 random(1);
  for (int run = 0; run < 5; ++run) {
    const ScratchFolder folder;
    for (uint32_t begin = 0, part = 0; begin < 2000; ++part) {
      const uint32_t end = std::min(2000U, begin + 1 + static_cast<uint32_t>(random() % 700));
      write_part(folder / ("x.pcap" + (part == 0 ? "" : std::to_string(part))), begin, end);
      begin = end;
    }
    for (const fs::path& path : {folder / "x.pcap", folder / "x.pcap*", folder.path()}) {
      const Reading reading = read(path);
      EXPECT_EQ(reading.numbers, range(0, 2000));
      EXPECT_EQ(reading.notes, "");
      EXPECT_EQ(reading.counters.datagrams, 2000U);
    }
  }
}

TEST(CaptureReader, ARingIsReadByTimeNotByNumber) {
  const ScratchFolder folder;  // tcpdump -W 3 has come round: file 1 is the oldest
  write_part(folder / "x.pcap0", 600, 900);
  write_part(folder / "x.pcap1", 0, 300);
  write_part(folder / "x.pcap2", 300, 600);
  const Reading reading = read(folder / "x.pcap0");
  EXPECT_EQ(reading.numbers, range(0, 900));
  EXPECT_EQ(reading.notes, "");
}

TEST(CaptureReader, AMissingPartAndAnOverlapAreNamed) {
  const ScratchFolder folder;
  write_part(folder / "x.pcap", 0, 300);
  write_part(folder / "x.pcap2", 600, 900);
  const Reading missing = read(folder / "x.pcap");
  EXPECT_EQ(missing.numbers.size(), 600U);
  EXPECT_THAT(missing.notes, HasSubstr("x.pcap2: 0.301 s are missing after x.pcap"));

  write_part(folder / "x.pcap1", 250, 650);
  const Reading overlapping = read(folder / "x.pcap");
  EXPECT_EQ(overlapping.numbers.size(), 1000U);
  EXPECT_TRUE(std::is_sorted(overlapping.numbers.begin(), overlapping.numbers.end()));
  EXPECT_THAT(overlapping.notes, HasSubstr("x.pcap: overlaps x.pcap1 by 0.049 s"));
  EXPECT_THAT(overlapping.notes, HasSubstr("x.pcap1: overlaps x.pcap2 by 0.049 s"));
}

TEST(CaptureReader, UnreadableAndEmptyPartsAreNamedAndTheOthersRead) {
  const ScratchFolder folder;
  write_part(folder / "x.pcap", 0, 300);
  write_part(folder / "x.pcap1", 300, 600);
  write_part(folder / "x.pcap2", 600, 600);  // just begun
  write(folder / "x.pcap3", {});
  fs::resize_file(folder / "x.pcap1", fs::file_size(folder / "x.pcap1") - 5);
  const Reading reading = read(folder / "x.pcap");
  EXPECT_EQ(reading.numbers, range(0, 599));
  EXPECT_THAT(reading.notes, HasSubstr("x.pcap3: cannot be read as pcap"));
  EXPECT_THAT(reading.notes, HasSubstr("cannot be read beyond packet 299"));
  EXPECT_EQ(reading.parts, 3U);

  const ScratchFolder empty;
  write(empty / "y.pcap", {});
  write(empty / "y.pcap1", {});
  EXPECT_THAT(read(empty / "y.pcap").notes, HasSubstr("y.pcap: cannot be read as pcap"));
}

TEST(CaptureReader, ManyOverlappingPartsAreReadWithinBounds) {
  const ScratchFolder folder;
  for (int part = 0; part < 30; ++part) {
    write_part(folder / ("x" + std::to_string(part) + ".pcap"), 0, 20);
  }
  const Reading reading = read(folder.path());
  EXPECT_EQ(reading.numbers.size(), 600U);
  EXPECT_THAT(reading.notes, HasSubstr("more problems of the captures"));
}

TEST(CaptureReader, FiltersEveryPart) {
  const ScratchFolder folder;
  write_part(folder / "x.pcap", 0, 300);
  write_part(folder / "x.pcap1", 300, 600);
  const Reading reading = read(folder / "x.pcap", {.ports = {9}});
  EXPECT_TRUE(reading.numbers.empty());
  EXPECT_EQ(reading.counters.filtered, 600U);
}

}  // namespace
}  // namespace infuse::recording

#include "drivers/recording/times_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<Stamp> stamps_of(const std::vector<TimesRow>& rows) {
  std::vector<Stamp> stamps;
  for (const TimesRow& row : rows) stamps.push_back(row.stamp);
  return stamps;
}

TEST(TimesCsv, ReadsTheColumnAtAnyPosition) {
  const ScratchFolder folder;
  folder.write("times.csv", "# not the header: names come first\n");
  EXPECT_FALSE(read_times(folder / "times.csv"));
  folder.write("times.csv", "source, stamp_ns\r\na.png, 10\r\n\r\n# a remark\nb.png,-20\n");
  const auto times = read_times(folder / "times.csv");
  ASSERT_TRUE(times) << times.error().message();
  EXPECT_THAT(stamps_of(*times), ElementsAre(Stamp::from_ns(10), Stamp::from_ns(-20)));
}

TEST(TimesCsv, ReportsTheLineOfAnInvalidRow) {
  const ScratchFolder folder;
  folder.write("times.csv", "stamp_ns\n1\n2.5\n");
  EXPECT_THAT(read_times(folder / "times.csv").error().message(), HasSubstr("times.csv:3: "));
  folder.write("times.csv", "stamp_ns\n99999999999999999999\n");
  EXPECT_THAT(read_times(folder / "times.csv").error().message(), HasSubstr("times.csv:2: "));
  folder.write("times.csv", "time\n1\n");
  EXPECT_THAT(read_times(folder / "times.csv").error().message(),
              HasSubstr("no column 'stamp_ns'"));
  EXPECT_FALSE(read_times(folder / "missing.csv"));
}

TEST(TimesCsv, IgnoresATruncatedLastRow) {
  const ScratchFolder folder;
  for (const std::string& rest : {std::string("-"), std::string(7, '\0')}) {
    folder.write("times.csv", "stamp_ns\n1\n2\n" + rest);
    const auto times = read_times(folder / "times.csv");
    ASSERT_TRUE(times) << times.error().message();
    EXPECT_THAT(stamps_of(*times), ElementsAre(Stamp::from_ns(1), Stamp::from_ns(2)));
  }
  folder.write("times.csv", "stamp_ns\n1\n-\n2");
  EXPECT_THAT(read_times(folder / "times.csv").error().message(), HasSubstr("times.csv:3: "));
}

TEST(TimesCsv, WriteAndReadRoundTrip) {
  const ScratchFolder folder;
  const std::vector<Stamp> stamps = {Stamp::from_ns(1'700'000'000'123'456'789), Stamp::earliest()};
  ASSERT_TRUE(write_times(folder / "a.csv", stamps));
  const std::vector<TimesRow> rows = {{.stamp = stamps[0]}, {.stamp = stamps[1]}};
  ASSERT_TRUE(write_times(folder / "b.csv", rows, {"x.png", "y.png"}));
  EXPECT_EQ(folder.read("b.csv"),
            "stamp_ns,source\n1700000000123456789,x.png\n-9223372036854775808,y.png\n");
  EXPECT_EQ(stamps_of(*read_times(folder / "a.csv")), stamps);
  EXPECT_EQ(stamps_of(*read_times(folder / "b.csv")), stamps);
}

TEST(TimesCsv, HoldsEndsOfSweepsAndExposures) {
  const ScratchFolder folder;
  const std::vector<TimesRow> rows = {
      {.stamp = Stamp::from_ns(1), .end = Stamp::from_ns(5), .exposure = {}},
      {.stamp = Stamp::from_ns(7), .end = {}, .exposure = Stamp::from_ns(6)}};
  ASSERT_TRUE(write_times(folder / "times.csv", rows, {"x", "y"}));
  EXPECT_EQ(folder.read("times.csv"), "stamp_ns,end_ns,exposure_ns,source\n1,5,,x\n7,,6,y\n");
  const auto times = read_times(folder / "times.csv");
  ASSERT_TRUE(times) << times.error().message();
  EXPECT_EQ(times->at(0).end, Stamp::from_ns(5));
  EXPECT_FALSE(times->at(0).exposure);
  EXPECT_FALSE(times->at(1).end);
  EXPECT_EQ(times->at(1).exposure, Stamp::from_ns(6));
}

TEST(TimesCsv, EverySweepHasASpan) {
  const ScratchFolder folder;
  folder.write("times.csv", "stamp_ns,end_ns\n0,90\n100,\n200,150\n300,9000000000\n400,390\n");
  for (const char* name : {"000000.bin", "000001.bin", "000002.bin", "000003.bin"})
    folder.write(name, "");
  const auto sweeps = index_sweeps(folder.path());
  ASSERT_TRUE(sweeps);
  std::vector<int64_t> spans;
  for (const SequenceEntry& entry : sweeps->entries) spans.push_back(entry.span.count());
  EXPECT_THAT(spans, ElementsAre(90, 100, 100, 100));  // 100: the usual time between two
  std::string notes;
  for (const Error& note : sweeps->notes) notes += note.message() + "\n";
  EXPECT_THAT(notes, HasSubstr("2 sweeps whose end is not within 2 s"));
}

TEST(TimesCsv, ExposuresPrecedeTheDelay) {
  const ScratchFolder folder;
  folder.write("times.csv", "stamp_ns,exposure_ns\n100,\n200,185\n");
  for (const char* name : {"000000.png", "000001.png"}) folder.write(name, "");
  const auto images = index_images(folder.path(), Duration(20));
  ASSERT_TRUE(images);
  EXPECT_EQ(images->entries[0].stamp.ns(), 80);
  EXPECT_EQ(images->entries[1].stamp.ns(), 185);
}

TEST(TimesCsv, MatchesNumberedFilesWithRows) {
  const ScratchFolder folder;
  folder.write("times.csv", "stamp_ns\n0\n100\n50\n300\n");
  for (const char* name : {"000000.png", "000001.jpg", "000002.png", "000002.jpg", "000009.png",
                           "thumbs.png", "-00001.png", "000003.txt"}) {
    folder.write(name, "");
  }
  const auto sequence = index_images(folder.path());
  ASSERT_TRUE(sequence);
  ASSERT_EQ(sequence->entries.size(), 3u);
  EXPECT_EQ(sequence->entries[0].path, folder / "000000.png");
  EXPECT_EQ(sequence->entries[1].path, folder / "000001.jpg");
  EXPECT_EQ(sequence->entries[1].stamp.ns(), 100);
  EXPECT_EQ(sequence->entries[2].path, folder / "000002.jpg");
  EXPECT_EQ(sequence->entries[2].number, 2u);
  std::string notes;
  for (const Error& note : sequence->notes) notes += note.message() + "\n";
  EXPECT_THAT(notes, HasSubstr("1 file beyond the last row"));
  EXPECT_THAT(notes, HasSubstr("1 row of times.csv without a file"));
  EXPECT_THAT(notes, HasSubstr("the stamps decrease 1 time"));
}

}  // namespace
}  // namespace infuse::recording

#include "drivers/text/csv_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "drivers/text/text_file.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::text {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::array<CsvColumn, 2> kColumns = {{{"b"}, {"c", false}}};

TEST(CsvReader, FindsColumnsByName) {
  const ScratchFolder folder;
  folder.write("x.csv", "a, b\r\n1, 2 \n\n# comment\n3\n");
  auto csv = CsvReader::open(folder / "x.csv", kColumns);
  ASSERT_TRUE(csv);
  std::array<std::string_view, 2> fields;
  ASSERT_TRUE(csv->next(fields));
  EXPECT_THAT(fields, ElementsAre("2", ""));
  ASSERT_TRUE(csv->next(fields));
  EXPECT_THAT(fields, ElementsAre("", ""));
  EXPECT_THAT(csv->where(), HasSubstr("x.csv:5"));
  EXPECT_FALSE(csv->next(fields));
}

TEST(CsvReader, RequiresColumns) {
  const ScratchFolder folder;
  folder.write("x.csv", "a,c\n1,2\n");
  EXPECT_THAT(CsvReader::open(folder / "x.csv", kColumns).error().message(),
              HasSubstr("x.csv:1: has no column 'b'"));
}

TEST(LineReader, SkipsAndCountsOverlongLines) {
  const ScratchFolder folder;
  folder.write("x", "one\r\n" + std::string(LineReader::kMaxLineBytes + 1, 'x') + "\n" +
                        std::string(3 * LineReader::kMaxLineBytes, 'y') + "\n\nlast");
  auto lines = LineReader::open(folder / "x");
  ASSERT_TRUE(lines);
  std::vector<std::string> read;
  for (std::string_view line; lines->next(line);) read.emplace_back(line);
  EXPECT_THAT(read, ElementsAre("one", "", "last"));
  EXPECT_EQ(lines->too_long_lines(), 2u);
  EXPECT_EQ(lines->line_number(), 5u);
}

TEST(TextFile, WriteAndReadRoundTrip) {
  const ScratchFolder folder;
  const std::string content("a\0b\n", 4);
  ASSERT_TRUE(write_text(folder / "x", content));
  EXPECT_EQ(*read_text(folder / "x", 4), content);
  EXPECT_THAT(read_text(folder / "x", 3).error().message(), HasSubstr("is longer than 3 bytes"));
  EXPECT_THAT(read_text(folder.path(), 3).error().message(), HasSubstr("is a folder"));
  EXPECT_FALSE(read_text(folder / "missing", 3));
  EXPECT_FALSE(write_text(folder / "no" / "folder", ""));
}

}  // namespace
}  // namespace infuse::text

#include "drivers/text/text_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "drivers/text/line_reader.hpp"
#include "drivers/text/printable.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::text {
namespace {

using testing::HasSubstr;

TEST(TextFile, PipesAndDevicesAreRefusedAtOnce) {
  const ScratchFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  for (const std::filesystem::path& path : {folder / "pipe", std::filesystem::path("/dev/zero")}) {
    EXPECT_THAT(read_text(path, 100).error().message(), HasSubstr("is not a regular file"));
    EXPECT_THAT(LineReader::open(path).error().message(), HasSubstr("is not a regular file"));
  }
  folder.write("text", "abc");
  EXPECT_EQ(read_text(folder / "text", 3).value(), "abc");
}

TEST(Printable, ReplacesWhatATerminalWouldObey) {
  EXPECT_EQ(printable("front \x1b[31mcamera\n"), "front ?[31mcamera?");
  EXPECT_EQ(printable("a\nb\x7f", "\n"), "a\nb?");
  EXPECT_EQ(printable("\xc2\x9b"
                      "1m, 3 \xc2\xb0, \xc3\xbc"),
            "??1m, 3 \xc2\xb0, \xc3\xbc");
  EXPECT_TRUE(is_name("caméra 1"));
  EXPECT_FALSE(is_name(""));
  EXPECT_FALSE(is_name("a\nb"));
  EXPECT_FALSE(is_name(std::string(65, 'a')));
}

}  // namespace
}  // namespace infuse::text

#include "daemon/pipeline/reports_file.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/daemon/pipeline/run_replay.hpp"

namespace infuse::daemon {
namespace {

TEST(ReportsFile, ALineForEachReport) {
  const TemporaryFolder folder;
  auto file = ReportsFile::create(folder / "reports.jsonl");
  ASSERT_TRUE(file) << file.error().message();
  file->write("{}");
  file->write("{\"a\":1}");
  EXPECT_TRUE(file->close());
  std::stringstream text;
  text << std::ifstream(folder / "reports.jsonl").rdbuf();
  EXPECT_EQ(text.str(), "{}\n{\"a\":1}\n");
}

TEST(ReportsFile, AFullDiskIsAnErrorAtTheEnd) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  auto file = ReportsFile::create("/dev/full");
  ASSERT_TRUE(file) << file.error().message();
  file->write("{}");  // fits the buffer: only the flush at the end fails
  const auto closed = file->close();
  ASSERT_FALSE(closed);
  EXPECT_NE(closed.error().message().find("No space left"), std::string::npos);
}

}  // namespace
}  // namespace infuse::daemon

#include "daemon/history/history_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

namespace infuse::daemon {
namespace {

using testing::ElementsAre;

class HistoryFileTest : public testing::Test {
 protected:
  HistoryFileTest() { std::filesystem::create_directories(folder_); }
  ~HistoryFileTest() override { std::filesystem::remove_all(folder_); }

  std::vector<std::string> lines() const { return read_history(path_).value(); }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("infuse-history-" + std::to_string(::getpid()));
  std::filesystem::path path_ = folder_ / kHistoryFile;
};

TEST_F(HistoryFileTest, LinesAreReadInTheirOrder) {
  EXPECT_TRUE(lines().empty());
  const HistoryFile file(path_);
  ASSERT_TRUE(file.append("a"));
  ASSERT_TRUE(HistoryFile(path_).append("b"));  // after a restart
  EXPECT_THAT(lines(), ElementsAre("a", "b"));
  struct stat about {};
  ASSERT_EQ(::stat(path_.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777, 0640U);
}

TEST_F(HistoryFileTest, ItsSizeIsBoundedAndTheNewestLinesAreKept) {
  const HistoryFile file(path_, 1000);
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(file.append("line " + std::to_string(i)));
    uint64_t bytes = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      bytes += entry.file_size();
    }
    ASSERT_LE(bytes, 2000U);
  }
  const auto kept = lines();
  EXPECT_GT(kept.size(), 100U);
  for (size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(kept[i], "line " + std::to_string(1000 - kept.size() + i));
  }
}

TEST_F(HistoryFileTest, APartOfALineCostsThatLineOnly) {
  const HistoryFile file(path_);
  ASSERT_TRUE(file.append("whole"));
  std::ofstream(path_, std::ios::app) << "par";  // a power cut
  ASSERT_TRUE(file.append("next"));
  EXPECT_THAT(lines(), ElementsAre("whole", "par", "next"));
}

TEST_F(HistoryFileTest, AFolderThatCannotBeReadIsNoEmptyHistory) {
  EXPECT_TRUE(lines().empty());
  EXPECT_FALSE(read_history(folder_ / "none" / kHistoryFile));
}

TEST_F(HistoryFileTest, ALinkIsNotFollowed) {
  std::filesystem::create_symlink(folder_ / "elsewhere", path_);
  EXPECT_FALSE(HistoryFile(path_).append("x"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "elsewhere"));
}

}  // namespace
}  // namespace infuse::daemon

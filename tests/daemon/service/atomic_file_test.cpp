#include "daemon/service/atomic_file.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <random>
#include <sstream>
#include <thread>

namespace infuse::daemon {
namespace {

struct Folder {
  std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) / ("infuse-atomic-" + std::to_string(getpid()));
  Folder() { std::filesystem::create_directories(path); }
  ~Folder() { std::filesystem::remove_all(path); }
};

std::string content(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(AtomicFile, ReplacesTheFileAndLeavesNoTemporaryFile) {
  const Folder folder;
  const auto path = folder.path / "state.json";
  ASSERT_TRUE(write_atomically(path, "old"));
  ASSERT_TRUE(write_atomically(path, "new"));
  EXPECT_EQ(content(path), "new");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path), {}), 1);
}

TEST(AtomicFile, AFailedWriteLeavesTheOldFile) {
  const Folder folder;
  const auto path = folder.path / "state.json";
  ASSERT_TRUE(write_atomically(path, "old"));
  std::filesystem::create_symlink(folder.path / "elsewhere", path.string() + ".new");
  EXPECT_FALSE(write_atomically(path, "new"));
  EXPECT_EQ(content(path), "old");
  EXPECT_FALSE(
      std::filesystem::exists(folder.path / "elsewhere"));  // symbolic links are not followed
  EXPECT_FALSE(write_atomically(folder.path / "none" / "state.json", "new"));
}

TEST(AtomicFile, AKillAtAnyMomentLeavesACompleteFile) {
  const Folder folder;
  const auto path = folder.path / "state.json";
  std::mt19937 random(1);
  for (int round = 0; round < 50; ++round) {
    const pid_t child = fork();
    if (child == 0) {
      for (char c = 'a';; c = c == 'z' ? 'a' : static_cast<char>(c + 1)) {
        static_cast<void>(write_atomically(path, std::string(20'000, c)));
      }
    }
    std::this_thread::sleep_for(std::chrono::microseconds(500 + random() % 5000));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    if (!std::filesystem::exists(path)) continue;
    const std::string text = content(path);
    ASSERT_EQ(text.size(), 20'000U);
    EXPECT_EQ(text.find_first_not_of(text[0]), std::string::npos);
  }
}

}  // namespace
}  // namespace infuse::daemon

#include "drivers/recording/atomic_file.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <random>
#include <thread>

#include "tests/scratch_folder.hpp"

namespace infuse::recording {
namespace {

Result<void> write_text(const std::filesystem::path& path, const std::string& text,
                        mode_t mode = 0640) {
  return write_file_atomically(path, std::as_bytes(std::span(text)), mode);
}

TEST(AtomicFile, ReplacesTheFileAndLeavesNoTemporaryFile) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_text(folder / "state.json", "old"));
  ASSERT_TRUE(write_text(folder / "state.json", "new"));
  EXPECT_EQ(folder.read("state.json"), "new");
  EXPECT_EQ(std::filesystem::status(folder / "state.json").permissions(),
            std::filesystem::perms(0640));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(AtomicFile, AFailedWriteLeavesWhatWasThereAndNoTemporaryFile) {
  const ScratchFolder folder;
  folder.write("state.json/file", "old");  // a folder cannot be replaced by a file
  EXPECT_FALSE(write_text(folder / "state.json", "new"));
  EXPECT_EQ(folder.read("state.json/file"), "old");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
  EXPECT_FALSE(write_text(folder / "none" / "state.json", "new"));
}

TEST(AtomicFile, AFileThatIsReplacedKeepsItsMode) {
  const ScratchFolder folder;
  folder.write("map", "old");
  std::filesystem::permissions(folder / "map", std::filesystem::perms(0600));
  ASSERT_TRUE(write_file_atomically(folder / "map", {}));
  EXPECT_EQ(std::filesystem::status(folder / "map").permissions(), std::filesystem::perms(0600));
  ASSERT_TRUE(write_file_atomically(folder / "map", {}, 0640));
  EXPECT_EQ(std::filesystem::status(folder / "map").permissions(), std::filesystem::perms(0640));
}

TEST(AtomicFile, ReplacesOnlyRegularFiles) {
  const ScratchFolder folder;
  folder.write("elsewhere", "old");
  std::filesystem::create_symlink(folder / "elsewhere", folder / "link");
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  for (const char* name : {"link", "pipe"}) {
    const auto written = write_text(folder / name, "new");
    ASSERT_FALSE(written) << name;
    EXPECT_NE(written.error().message().find("is not a regular file"), std::string::npos);
  }
  EXPECT_FALSE(write_text("/dev/null", "new"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_TRUE(std::filesystem::is_fifo(folder / "pipe"));
  EXPECT_EQ(folder.read("elsewhere"), "old");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 3);
}

TEST(AtomicFile, AKillAtAnyMomentLeavesACompleteFile) {
  const ScratchFolder folder;
  const auto path = folder / "state.json";
  std::mt19937 random(1);
  for (int round = 0; round < 50; ++round) {
    const pid_t child = fork();
    if (child == 0) {
      for (char c = 'a';; c = c == 'z' ? 'a' : static_cast<char>(c + 1)) {
        static_cast<void>(write_text(path, std::string(20'000, c)));
      }
    }
    std::this_thread::sleep_for(std::chrono::microseconds(500 + random() % 5000));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    if (!std::filesystem::exists(path)) continue;
    const std::string text = folder.read("state.json");
    ASSERT_EQ(text.size(), 20'000U);
    EXPECT_EQ(text.find_first_not_of(text[0]), std::string::npos);
  }
}

}  // namespace
}  // namespace infuse::recording

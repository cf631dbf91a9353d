#include "daemon/process/crash_note.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <functional>
#include <sstream>
#include <thread>

#include "daemon/process/abort_marker.hpp"
#include "tests/faults/disk_fault.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

/// Ends the process by a signal, far from any other code.
__attribute__((noinline)) void crash_here(int signal) { raise(signal); }

/// Overflows the stack of 8 MB.
__attribute__((noinline)) int overflow_stack(int frames) {
  volatile char frame[4096];
  frame[0] = static_cast<char>(frames);
  return frames == 0 ? 0 : overflow_stack(frames - 1) + frame[0];
}

class CrashNoteTest : public testing::Test {
 protected:
  /// Runs a process with the handlers installed and returns the signal that ended it.
  int signal_of(const std::function<void()>& what_it_does) const {
    const pid_t child = fork();
    if (child == 0) {
      install_crash_handler(file_);
      install_abort_handler(folder_ / "abort_marker");
      what_it_does();
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }
  std::string note() const {
    std::ifstream file(file_);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  const ScratchFolder folder_;
  const std::filesystem::path file_ = folder_ / "crash_note";
};

TEST_F(CrashNoteTest, NamesTheSignalAndTheLastReports) {
  EXPECT_EQ(signal_of([] {
              remember_report("first");
              remember_report("3 of 3 sensors are OK");
              crash_here(SIGSEGV);
            }),
            SIGSEGV);
  EXPECT_THAT(note(), testing::StartsWith("signal 11\n"));
  EXPECT_THAT(note(), HasSubstr("last reports:\n3 of 3 sensors are OK"));
  EXPECT_THAT(note(), testing::Not(HasSubstr("first")));
}

TEST_F(CrashNoteTest, AnOverflowOfTheStackLeavesANote) {
  EXPECT_EQ(signal_of([] { overflow_stack(1'000'000); }), SIGSEGV);
  EXPECT_THAT(note(), testing::StartsWith("signal 11\n"));
  std::filesystem::remove(file_);
  const auto in_a_thread = [] {
    std::thread([] {
      use_crash_stack();
      overflow_stack(1'000'000);
    }).join();
  };
  EXPECT_EQ(signal_of(in_a_thread), SIGSEGV);
  EXPECT_THAT(note(), testing::StartsWith("signal 11\n"));
}

// The process ends by its signal, and what is there stays.
TEST_F(CrashNoteTest, OnADiskThatFailsThereIsNoNoteAndNothingElseChanges) {
  const std::filesystem::path marker = folder_ / "abort_marker";
  for (const int error : {ENOSPC, EIO, EROFS}) {
    const DiskFault fault(folder_.path(), error);
    EXPECT_EQ(signal_of([] { crash_here(SIGSEGV); }), SIGSEGV);
    EXPECT_EQ(signal_of([] {
                kill(getpid(), SIGABRT);  // as from the service manager
                pause();
              }),
              SIGABRT);
    EXPECT_FALSE(std::filesystem::exists(file_)) << error;
    EXPECT_FALSE(std::filesystem::exists(marker)) << error;
    EXPECT_FALSE(keep_crash_note(file_, "x"));
    EXPECT_FALSE(consume_abort_marker(marker));
  }
  EXPECT_EQ(signal_of([] { crash_here(SIGSEGV); }), SIGSEGV);
  const std::string before = note();
  {
    const DiskFault fault(folder_.path(), EROFS);
    EXPECT_EQ(signal_of([] { crash_here(SIGBUS); }), SIGBUS);
    EXPECT_EQ(note(), before);
    EXPECT_FALSE(keep_crash_note(file_, "x"));  // it cannot be moved
  }
  EXPECT_TRUE(keep_crash_note(file_, "x"));
}

// The independent truth is the address of this program's own code, as the linker placed it.
TEST_F(CrashNoteTest, ACallIsFoundByItsAddressInTheFile) {
  EXPECT_EQ(signal_of([] { crash_here(SIGBUS); }), SIGBUS);
  std::istringstream lines(note());
  bool found = false;
  for (std::string line; std::getline(lines, line) && !found;) {
    std::istringstream words(line);
    std::string address, file, build_id;
    words >> address >> file >> build_id;
    if (file != program_invocation_short_name && file.find("tests_") != 0) continue;
    EXPECT_GE(build_id.size(), 32U) << line;
    const std::string name =
        "addr2line -f -C -e /proc/" + std::to_string(getpid()) + "/exe " + address + " 2>/dev/null";
    std::FILE* pipe = popen(name.c_str(), "r");
    std::array<char, 1024> bytes{};
    const size_t size = std::fread(bytes.data(), 1, bytes.size(), pipe);
    const bool usable = pclose(pipe) == 0;
    if (!usable) GTEST_SKIP() << "addr2line is not installed";
    found = std::string(bytes.data(), size).find("crash_here") != std::string::npos;
  }
  EXPECT_TRUE(found) << note();
}

TEST_F(CrashNoteTest, AnAbortLeavesANote) {
  EXPECT_EQ(signal_of([] { abort(); }), SIGABRT);
  EXPECT_THAT(note(), testing::StartsWith("signal 6\n"));
}

TEST_F(CrashNoteTest, AProcessThatExitsLeavesNone) {
  EXPECT_EQ(signal_of([] {}), 0);
  EXPECT_FALSE(std::filesystem::exists(file_));
  EXPECT_FALSE(keep_crash_note(file_, "1"));
}

TEST_F(CrashNoteTest, TheNewestNotesAreKept) {
  for (int i = 10; i < 30; ++i) {
    folder_.write("crash_note", "signal " + std::to_string(i) + "\n\ncalls");
    const auto kept = keep_crash_note(file_, std::to_string(i));
    ASSERT_TRUE(kept.has_value());
    EXPECT_EQ(*kept, "signal " + std::to_string(i) + ", see " +
                         (folder_ / ("crash-" + std::to_string(i) + ".txt")).string());
  }
  EXPECT_TRUE(std::filesystem::exists(folder_ / "crash-29.txt"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "crash-22.txt"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "crash-21.txt"));
}

}  // namespace
}  // namespace infuse::daemon

#include "daemon/process/abort_marker.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <functional>

namespace infuse::daemon {
namespace {

class AbortMarker : public testing::Test {
 protected:
  void SetUp() override { unlink(file_.c_str()); }
  void TearDown() override { unlink(file_.c_str()); }

  /// Runs a process with the abort handler installed. Returns how it ended.
  int exit_status_of(const std::function<void()>& what_it_does) const {
    const pid_t child = fork();
    if (child == 0) {
      install_abort_handler(file_);
      what_it_does();
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return status;
  }

  const std::filesystem::path file_ =
      testing::TempDir() + "infuse-abort-note-" + std::to_string(getpid());
};

TEST_F(AbortMarker, IsLeftByAProcessAbortedByAnother) {
  const int status = exit_status_of([] {
    kill(getpid(), SIGABRT);  // as from another process
    pause();
  });
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGABRT);
  EXPECT_TRUE(consume_abort_marker(file_));
  EXPECT_FALSE(consume_abort_marker(file_));  // consumed
}

TEST_F(AbortMarker, IsNotLeftByAProcessThatAbortsItself) {
  const int status = exit_status_of([] { abort(); });
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGABRT);
  EXPECT_FALSE(consume_abort_marker(file_));
}

TEST_F(AbortMarker, IsNotLeftByAProcessThatExitsOrIsKilled) {
  EXPECT_EQ(exit_status_of([] {}), 0);
  EXPECT_FALSE(consume_abort_marker(file_));
  EXPECT_TRUE(WIFSIGNALED(exit_status_of([] { raise(SIGKILL); })));
  EXPECT_FALSE(consume_abort_marker(file_));
}

TEST_F(AbortMarker, DoesNotFollowSymbolicLinks) {
  const std::string elsewhere = file_.string() + "-elsewhere";
  ASSERT_EQ(symlink(elsewhere.c_str(), file_.c_str()), 0);
  EXPECT_TRUE(WIFSIGNALED(exit_status_of([] { kill(getpid(), SIGABRT); })));
  EXPECT_NE(access(elsewhere.c_str(), F_OK), 0);
}

}  // namespace
}  // namespace infuse::daemon

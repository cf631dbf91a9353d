#include "daemon/service/abort_note.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <functional>

namespace infuse::daemon {
namespace {

class AbortNote : public testing::Test {
 protected:
  void SetUp() override { unlink(file_.c_str()); }
  void TearDown() override { unlink(file_.c_str()); }

  /// A process that would leave a note. How it ended.
  int end_of_process(const std::function<void()>& what_it_does) const {
    const pid_t child = fork();
    if (child == 0) {
      leave_note_on_abort(file_);
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

TEST_F(AbortNote, IsLeftByAProcessThatIsAbortedFromOutside) {
  const int status = end_of_process([] {
    kill(getpid(), SIGABRT);  // as another process would
    pause();
  });
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGABRT);
  EXPECT_TRUE(take_abort_note(file_));
  EXPECT_FALSE(take_abort_note(file_));  // it is gone
}

TEST_F(AbortNote, IsNotLeftByOneThatAbortsByItself) {
  const int status = end_of_process([] { abort(); });
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGABRT);
  EXPECT_FALSE(take_abort_note(file_));
}

TEST_F(AbortNote, IsNotLeftByOneThatEndsOrIsKilled) {
  EXPECT_EQ(end_of_process([] {}), 0);
  EXPECT_FALSE(take_abort_note(file_));
  EXPECT_TRUE(WIFSIGNALED(end_of_process([] { raise(SIGKILL); })));
  EXPECT_FALSE(take_abort_note(file_));
}

TEST_F(AbortNote, FollowsNoLink) {
  const std::string elsewhere = file_.string() + "-elsewhere";
  ASSERT_EQ(symlink(elsewhere.c_str(), file_.c_str()), 0);
  EXPECT_TRUE(WIFSIGNALED(end_of_process([] { kill(getpid(), SIGABRT); })));
  EXPECT_NE(access(elsewhere.c_str(), F_OK), 0);
}

}  // namespace
}  // namespace infuse::daemon

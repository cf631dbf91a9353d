#include "daemon/owner/config_trial.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <random>
#include <thread>

#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

class ConfigTrialTest : public testing::Test {
 protected:
  ConfigTrialTest() { folder_.write("infused.toml", "old"); }
  std::string in_place() const { return folder_.read("infused.toml"); }

  const ScratchFolder folder_;
  const ConfigTrial trial_{folder_ / "infused.toml"};
};

TEST_F(ConfigTrialTest, AConfirmedConfigurationStays) {
  ASSERT_TRUE(trial_.begin("new"));
  EXPECT_EQ(in_place(), "new");
  EXPECT_FALSE(trial_.settle().value());  // this process waits for it
  ASSERT_TRUE(trial_.confirm());
  EXPECT_FALSE(trial_.settle().value());
  EXPECT_EQ(in_place(), "new");
  EXPECT_EQ(folder_.read("infused.toml.previous"), "old");
}

TEST_F(ConfigTrialTest, TheOneBeforeComesBack) {
  ASSERT_TRUE(trial_.begin("new"));
  EXPECT_FALSE(trial_.begin("newer"));  // one at a time
  ASSERT_TRUE(trial_.restore());
  EXPECT_EQ(in_place(), "old");
}

TEST_F(ConfigTrialTest, ACopyIsAsSecretAsTheOriginal) {
  std::filesystem::permissions(folder_ / "infused.toml", std::filesystem::perms(0600));
  ASSERT_TRUE(trial_.begin("new"));
  for (const char* name : {"infused.toml", "infused.toml.previous"}) {
    EXPECT_EQ(std::filesystem::status(folder_ / name).permissions(), std::filesystem::perms(0600));
  }
}

TEST_F(ConfigTrialTest, AKillAtAnyMomentLeavesOneOfTheTwo) {
  std::mt19937 random(1);
  for (int round = 0; round < 200; ++round) {
    folder_.write("infused.toml", "old");
    const pid_t child = fork();
    if (child == 0) {
      const bool begun = trial_.begin("new").has_value();
      ::_exit(begun && trial_.confirm() ? 0 : 1);
    }
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 3000));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(trial_.settle());
    const bool ended = WIFEXITED(status);
    if (ended) {
      ASSERT_EQ(WEXITSTATUS(status), 0);
    }
    const bool trying = std::filesystem::exists(folder_ / "infused.toml.trying");
    EXPECT_FALSE(trying);
    EXPECT_TRUE(in_place() == "new" || (!ended && in_place() == "old")) << in_place();
  }
}

}  // namespace
}  // namespace infuse::daemon

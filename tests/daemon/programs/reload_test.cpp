// The live daemon reads its configuration again.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "tests/daemon/live_daemon.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

constexpr const char* kFirst =
    "version = \"first\"\nlog_level = \"off\"\n[health]\nstale_after_s = 3\n"
    "[socket]\nmax_clients = 8\n[record]\nkeep_alerts = 3\n";

TEST(Reload, TheVersionIsThatOfTheLastReload) {
  const ScratchFolder folder;
  LiveDaemon daemon(folder, kFirst);
  EXPECT_THAT(daemon.wait_for(" first"), HasSubstr("configuration "));
  folder.write("infused.toml", "version = \"second\"\n");
  kill(daemon.process(), SIGHUP);
  EXPECT_THAT(daemon.wait_for(" second"), HasSubstr(" second\n"));
  EXPECT_EQ(daemon.stop(), 0);
}

TEST(Reload, FiveHundredDamagedConfigurationsDoNotEndTheDaemon) {
  const ScratchFolder folder;
  LiveDaemon daemon(folder, kFirst);
  daemon.wait_for(" first");
  std::mt19937 random(1);
  const std::string valid = kFirst;
  for (int round = 0; round < 500; ++round) {
    std::string text = valid;
    for (auto changes = 1 + random() % 8; changes > 0; --changes) {
      const size_t at = random() % text.size();
      if (random() % 3 == 0) {
        text.insert(at, text.substr(random() % text.size(), random() % 40));
      } else {
        text[at] = static_cast<char>(random());
      }
    }
    folder.write("infused.toml", text);
    kill(daemon.process(), SIGHUP);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  folder.write("infused.toml", kFirst);
  kill(daemon.process(), SIGHUP);
  EXPECT_THAT(daemon.wait_for(" first"), HasSubstr(" first\n"));
  EXPECT_EQ(daemon.stop(), 0);
}

TEST(Reload, ASecondDaemonDoesNotTakeTheStateDirectory) {
  const ScratchFolder folder;
  LiveDaemon daemon(folder, kFirst);
  daemon.wait_for(" first");
  const auto second =
      run_shell_command("STATE_DIRECTORY=" + (folder / "state").string() + " " + programs_folder() +
                        "/infused --config " + (folder / "infused.toml").string() + " --socket " +
                        (folder / "other").string() + " 2>&1");
  EXPECT_EQ(second.code, 2);
  EXPECT_THAT(second.output, HasSubstr("another infused uses this state directory"));
  EXPECT_EQ(daemon.stop(), 0);
}

/// `infuse config apply` with a restart that is a reload of this daemon.
ProgramResult apply(const ScratchFolder& folder, const LiveDaemon& daemon, const char* wait_s) {
  return run_shell_command(
      "PATH=" + programs_folder() + ":$PATH infuse config apply " + (folder / "new.toml").string() +
      " --target " + (folder / "infused.toml").string() + " --socket " + (folder / "s").string() +
      " --restart 'kill -HUP " + std::to_string(daemon.process()) + "' --wait " + wait_s + " 2>&1");
}

TEST(Reload, AConfigurationThatIsWrongOrNotReadyInTimeIsTakenBack) {
  const ScratchFolder folder;
  LiveDaemon daemon(folder, kFirst);
  daemon.wait_for(" first");
  folder.write("new.toml", "version = 7\n");
  const ProgramResult wrong = apply(folder, daemon, "1");
  EXPECT_EQ(wrong.code, 2) << wrong.output;
  EXPECT_THAT(wrong.output, HasSubstr("infused.toml:1: version"));
  EXPECT_EQ(folder.read("infused.toml"), kFirst);
  folder.write("new.toml", "version = \"new\"\n");  // without sensors it is never ready
  const ProgramResult late = apply(folder, daemon, "1.5");
  EXPECT_EQ(late.code, 1) << late.output;
  EXPECT_THAT(late.output, HasSubstr("not ready after 1.5 s: waits for"));
  EXPECT_EQ(folder.read("infused.toml"), kFirst);
  EXPECT_THAT(daemon.wait_for(" first"), HasSubstr(" first\n"));
  EXPECT_FALSE(std::filesystem::exists(folder / "infused.toml.trying"));
}

// INFUSE_KILLS=200 in the environment: as many moments; by default ten.
TEST(Reload, AKilledApplyLeavesTheOldConfigurationOrTheNew) {
  const ScratchFolder folder;
  LiveDaemon daemon(folder, kFirst);
  daemon.wait_for(" first");
  const std::string next = "version = \"next\"\n" + std::string(20'000, '#') + "\n";
  folder.write("new.toml", next);
  const std::string program = programs_folder() + "/infuse", to_apply = folder / "new.toml",
                    target = folder / "infused.toml", socket = folder / "s",
                    restart = "kill -HUP " + std::to_string(daemon.process());
  const char* asked = std::getenv("INFUSE_KILLS");
  const int kills = asked != nullptr ? std::atoi(asked) : 10;
  std::mt19937 random(1);
  for (int k = 0; k < kills; ++k) {
    const pid_t child = fork();
    if (child == 0) {
      static_cast<void>(std::freopen("/dev/null", "w", stderr));
      ::setenv("PATH", (programs_folder() + ":" + std::getenv("PATH")).c_str(), 1);
      ::execl(program.c_str(), "infuse", "config", "apply", to_apply.c_str(), "--target",
              target.c_str(), "--socket", socket.c_str(), "--restart", restart.c_str(), "--wait",
              "0.1", nullptr);
      ::_exit(127);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(random() % 300));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    const std::string left = folder.read("infused.toml");
    ASSERT_TRUE(left == kFirst || left == next) << left.substr(0, 200);
    const ProgramResult settled =
        run_shell_command(program + " config settle --target " + target + " 2>&1");
    ASSERT_EQ(settled.code, 0) << settled.output;
    ASSERT_EQ(folder.read("infused.toml"), kFirst);  // without sensors none is ever confirmed
    ASSERT_FALSE(std::filesystem::exists(folder / "infused.toml.trying"));
  }
  kill(daemon.process(), SIGHUP);
  EXPECT_THAT(daemon.wait_for(" first"), HasSubstr(" first\n"));
  EXPECT_EQ(daemon.stop(), 0);
}

}  // namespace
}  // namespace infuse::daemon

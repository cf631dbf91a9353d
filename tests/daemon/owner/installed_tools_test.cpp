// How `infuse` finds its tools, in a folder with made-up ones.

#include "daemon/owner/installed_tools.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "daemon/command_line/tool.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/folders.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class InstalledTools : public testing::Test {
 protected:
  void add(const std::string& name, const std::string& script, bool executable = true) {
    const auto path = folder_.path() / name;
    std::ofstream(path) << "#!/bin/sh\n" << script << "\n";
    if (executable) std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  }

  /// Output and errors of `infuse`, which looks for tools in the folder.
  ProgramResult run(const std::string& arguments) {
    return run_shell_command("INFUSE_EXEC_PATH=" + folder_.path().string() + " " +
                             programs_folder() + "/infuse " + arguments + " 2>&1");
  }

  ScratchFolder folder_;
};

TEST_F(InstalledTools, AreTheProgramsOfTheirFolder) {
  add("infuse-map", "");
  add("infuse-hello", "");
  add("infuse-notes", "", false);
  add("other", "");
  EXPECT_THAT(installed_tools(folder_.path()), ElementsAre("hello", "map"));
  EXPECT_TRUE(installed_tools(folder_.path() / "none").empty());
}

TEST_F(InstalledTools, GetTheArgumentsAndGiveTheExitCode) {
  add("infuse-hello", "printf '%s|' \"$@\"; exit 7");
  const auto result = run("hello --json 'a b' ''");
  EXPECT_EQ(result.output, "--json|a b||");
  EXPECT_EQ(result.code, 7);
}

TEST_F(InstalledTools, DoNotHideTheOwnersCommands) {
  add("infuse-status", "echo hidden");
  EXPECT_THAT(run("status --help").output, Not(HasSubstr("hidden")));
}

TEST_F(InstalledTools, ThatAreMissingAreInAPackage) {
  const auto result = run("calibrate drive");
  EXPECT_EQ(result.output,
            "infuse: 'calibrate' is not installed (it is in the package infuse-tools)\n");
  EXPECT_EQ(result.code, 2);
}

TEST_F(InstalledTools, ThatCannotBeRunAreNamed) {
  add("infuse-hello", "");
  std::ofstream(folder_.path() / "infuse-hello") << "#!/nonexistent\n";
  const auto result = run("hello");
  EXPECT_THAT(result.output, HasSubstr("infuse-hello"));
  EXPECT_EQ(result.code, 2);
}

TEST_F(InstalledTools, AreListedByTheHelp) {
  add("infuse-map", "");
  add("infuse-hello", "");
  for (const char* arguments : {"--help", "help", ""}) {
    const std::string help = run(arguments).output;
    const std::string tools = help.substr(std::min(help.find("\nTools:\n"), help.size()));
    EXPECT_THAT(tools, HasSubstr("\n  hello"));
    EXPECT_THAT(tools, HasSubstr("\n  map  "));
    EXPECT_THAT(
        tools,
        HasSubstr("Not installed (package infuse-tools): align, calibrate, "
                  "calibrate-intrinsics, calibrate-target, export, fleet, import, places\n"));
  }
  EXPECT_EQ(run("help").code, 0);
  EXPECT_EQ(run("").code, 2);
}

TEST_F(InstalledTools, AreHelpedToo) {
  add("infuse-hello", "echo \"$@\"");
  EXPECT_EQ(run("help hello").output, "--help\n");
  EXPECT_THAT(run("help status").output, HasSubstr("--socket"));
}

TEST(Tools, AreFoundByName) {
  ASSERT_NE(find_tool("calibrate-target"), nullptr);
  EXPECT_STREQ(find_tool("calibrate-target")->name, "calibrate-target");
  EXPECT_EQ(find_tool("status"), nullptr);
}

}  // namespace
}  // namespace infuse::daemon

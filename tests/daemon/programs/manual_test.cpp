// The manual pages and --help list the same options, and every help shows two examples.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <set>

#include "drivers/text/text_file.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {
namespace {

using Options = std::set<std::string>;

/// Sub-commands of infuse, as typed.
const std::vector<std::string> kCommands = {
    "status",        "watch",
    "wait-ready",    "record",
    "config",        "diagnose",
    "calibration",   "calibrations",
    "recalibrate",   "apply",
    "rollback",      "freeze",
    "inspect",       "decode",
    "import kitti",  "calibrate",
    "evaluate",      "calibrate-target",
    "streetmap",     "import opencalib",
    "odometry",      "places",
    "align",         "history",
    "import rosbag", "import lcm",
    "import ford",   "import folder",
    "export mcap",   "report",
    "map optimize",  "map",
    "map export",    "map merge",
    "map locate",    "fleet drive",
    "fleet pool",    "calibrate-intrinsics",
};

std::string help_of(const std::string& program) {
  const ProgramResult result = run_shell_command(programs_folder() + "/" + program + " --help");
  EXPECT_EQ(result.code, 0) << program;
  return result.output;
}

std::string manual(const std::string& name) {
  const auto text =
      text::read_text(std::filesystem::path(source_folder()) / "packaging/man" / name, 1 << 20);
  EXPECT_TRUE(text.has_value()) << name;
  return std::regex_replace(text.value_or(""), std::regex(R"(\\-)"), "-");
}

/// Part of a manual from a heading (".SS infuse status") to the next one.
std::string section(const std::string& text, const std::string& heading) {
  const auto begin = text.find("\n" + heading);
  if (begin == std::string::npos) return "";
  const auto body = text.find('\n', begin + 1);
  const auto end = std::min(text.find("\n.SS", body), text.find("\n.SH", body));
  return text.substr(body, end - body);
}

/// Long options in a text, other than --help and --version.
Options options_in(const std::string& text) {
  const std::regex pattern("--[a-z][a-z-]*");
  Options options;
  for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at) {
    options.insert(at->str());
  }
  options.erase("--help");
  options.erase("--version");
  return options;
}

/// Options of a help text: those that begin a line, "  -o,--output" or "  --json".
Options listed_options(const std::string& help) {
  const std::regex pattern(R"(\n +(-[a-z],)?(--[a-z][a-z-]*))");
  Options options;
  for (std::sregex_iterator at(help.begin(), help.end(), pattern), end; at != end; ++at) {
    options.insert((*at)[2].str());
  }
  options.erase("--help");
  options.erase("--version");
  return options;
}

void expect_two_examples(const std::string& program, const std::string& help) {
  const auto examples = help.find("Examples:\n");
  ASSERT_NE(examples, std::string::npos) << program;
  const std::regex line("\n  " + program.substr(0, program.find(' ')) + " [^\n]+");
  const std::string text = help.substr(examples);
  EXPECT_EQ(std::distance(std::sregex_iterator(text.begin(), text.end(), line), {}), 2) << help;
}

TEST(Manual, InfuseListsTheOptionsOfEveryCommand) {
  const std::string text = manual("infuse.1");
  for (const std::string& command : kCommands) {
    const std::string help = help_of("infuse " + command);
    EXPECT_EQ(options_in(section(text, ".SS infuse " + command + " ")), listed_options(help))
        << command;
    expect_two_examples("infuse " + command, help);
  }
}

TEST(Manual, InfuseListsEveryCommand) {
  const std::string help = help_of("infuse");
  const auto begin = help.find("Subcommands:");
  ASSERT_NE(begin, std::string::npos);
  const std::string list = help.substr(begin, help.find("Examples:", begin) - begin);
  const std::regex pattern("\n  ([a-z][a-z-]*) ");
  std::set<std::string> listed, known;
  for (std::sregex_iterator at(list.begin(), list.end(), pattern), end; at != end; ++at) {
    listed.insert((*at)[1].str());
  }
  for (const std::string& command : kCommands) known.insert(command.substr(0, command.find(' ')));
  EXPECT_EQ(listed, known);
  expect_two_examples("infuse", help);
}

TEST(Manual, InfusedListsItsOptions) {
  const std::string help = help_of("infused");
  EXPECT_EQ(options_in(section(manual("infused.8"), ".SH OPTIONS")), listed_options(help));
  expect_two_examples("infused", help);
}

TEST(Manual, InfuseSimulateListsItsOptions) {
  if (!std::filesystem::exists(programs_folder() + "/infuse-simulate")) {
    GTEST_SKIP() << "infuse-simulate is not built";
  }
  const std::string help = help_of("infuse-simulate");
  EXPECT_EQ(options_in(section(manual("infuse-simulate.1"), ".SH OPTIONS")), listed_options(help));
  expect_two_examples("infuse-simulate", help);
}

}  // namespace
}  // namespace infuse::daemon

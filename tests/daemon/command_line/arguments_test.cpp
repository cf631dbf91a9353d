#include "daemon/command_line/arguments.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

std::optional<int> parse(CLI::App& app, std::vector<std::string> words) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const auto code = parse_arguments(app, static_cast<int>(argv.size()), argv.data());
  testing::internal::GetCapturedStdout();
  testing::internal::GetCapturedStderr();
  return code;
}

TEST(Arguments, HelpAndWrongUsageEndTheProgram) {
  CLI::App app;
  int number = 0;
  app.add_option("--number", number);
  EXPECT_EQ(parse(app, {"x", "--number", "7"}), std::nullopt);
  EXPECT_EQ(number, 7);
  EXPECT_EQ(parse(app, {"x", "--help"}), int{kDone});
  EXPECT_EQ(parse(app, {"x", "--nonsense"}), int{kUsage});
  EXPECT_EQ(parse(app, {"x", "--number", "seven"}), int{kUsage});
}

TEST(Arguments, ExamplesAreAtTheEndOfTheHelp) {
  CLI::App app;
  set_examples(app, {"x one", "x two"});
  EXPECT_THAT(app.help(), testing::HasSubstr("Examples:\n  x one\n  x two"));
}

TEST(Arguments, ARateIsANumberOrMax) {
  EXPECT_FALSE(parse_rate("max").value().has_value());
  EXPECT_EQ(parse_rate("1").value().value(), 1);
  EXPECT_EQ(parse_rate("0.01").value().value(), 0.01);
  for (const char* text : {"", "0", "-1", "1001", "nan", "1x", "fast"}) {
    EXPECT_FALSE(parse_rate(text).has_value()) << text;
  }
}

TEST(Arguments, ErrorsArePrintedWithTheProgramsName) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(print_error("x", {"unknown key", "a.toml:3", "known: b"}, kUsage), 2);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "x: a.toml:3: unknown key (known: b)\n");
}

}  // namespace
}  // namespace infuse::daemon

#include "daemon/command_line/arguments.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

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

TEST(Arguments, WrongUsageBeginsWithTheProgramsName) {
  CLI::App app;
  app.add_option("--number")->check(CLI::Number);
  for (std::string word : {"--nonsense", "--number=seven"}) {
    std::string program = "/usr/bin/infuse";
    std::array<char*, 2> argv = {program.data(), word.data()};
    testing::internal::CaptureStderr();
    EXPECT_EQ(parse_arguments(app, 2, argv.data()), int{kUsage});
    const std::string message = testing::internal::GetCapturedStderr();
    EXPECT_THAT(message, testing::StartsWith("infuse: "));
    EXPECT_THAT(message, testing::EndsWith(" (--help lists the options)\n"));
    EXPECT_EQ(std::ranges::count(message, '\n'), 1) << message;
  }
}

TEST(Arguments, WrongValuesAreAnsweredWithASentence) {
  const auto message = [](std::vector<std::string> words) {
    CLI::App app;
    int alignment = 0;
    std::string show;
    CLI::App* const evaluate = app.add_subcommand("evaluate");
    evaluate->add_option("--align", alignment)
        ->transform(CLI::CheckedTransformer(std::map<std::string, int>{{"first", 1}, {"none", 0}}));
    evaluate->add_option("--show", show)->check(CLI::IsMember({"intensity", "height"}));
    double scale = 0, size = 0, wait = 0;
    size_t scenes = 0;
    evaluate->add_option("--scale", scale)->check(CLI::Range(0.05, 100.0));
    evaluate->add_option("--size", size)->check(CLI::PositiveNumber);
    evaluate->add_option("--wait", wait);
    evaluate->add_option("--scenes", scenes)->type_name("N");
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    testing::internal::CaptureStderr();
    EXPECT_EQ(parse_arguments(app, static_cast<int>(argv.size()), argv.data()), int{kUsage});
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(message({"infuse", "evaluate", "--align", "x"}),
            "infuse evaluate: --align must be one of first, none, not 'x' (--help lists the "
            "options)\n");
  EXPECT_EQ(message({"infuse", "evaluate", "--show", "x"}),
            "infuse evaluate: --show must be one of intensity, height, not 'x' (--help lists the "
            "options)\n");
  const std::vector<std::pair<std::array<std::string, 2>, std::string>> refused = {
      {{"--scale", "101"}, "--scale must be between 0.05 and 100, not '101'"},
      {{"--scale", "wrong"}, "--scale must be between 0.05 and 100, not 'wrong'"},
      {{"--size", "0"}, "--size must be above 0, not '0'"},
      {{"--wait", "wrong"}, "--wait must be a number, not 'wrong'"},
      {{"--scenes", "1.5"}, "--scenes must be a whole number, not '1.5'"},
      {{"--scenes", "-1"}, "--scenes must be at least 0, not '-1'"}};
  for (const auto& [words, sentence] : refused) {
    EXPECT_EQ(message({"infuse", "evaluate", words[0], words[1]}),
              "infuse evaluate: " + sentence + " (--help lists the options)\n");
  }
  EXPECT_EQ(message({"infuse", "evaluate", "--scale"}),
            "infuse evaluate: --scale needs a value (--help lists the options)\n");
  EXPECT_EQ(message({"infuse", "evaluate", "--nonsense"}),
            "infuse evaluate: unknown argument: --nonsense (--help lists the options)\n");
}

TEST(Arguments, AMistypedCommandIsAnsweredWithTheNearestOne) {
  CLI::App app;
  app.require_subcommand(1);
  app.add_subcommand("calibrate")->add_option("FILE");
  app.add_subcommand("inspect");
  const auto message = [&](std::string word) {
    std::string program = "/usr/bin/infuse";
    std::array<char*, 2> argv = {program.data(), word.data()};
    testing::internal::CaptureStderr();
    EXPECT_EQ(parse_arguments(app, 2, argv.data()), int{kUsage});
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(message("calibrat"),
            "infuse: 'calibrat' is not a command (did you mean 'calibrate'?)\n");
  EXPECT_THAT(message("inpsect"), testing::HasSubstr("did you mean 'inspect'?"));
  EXPECT_EQ(message("x"), "infuse: 'x' is not a command (--help lists the commands)\n");
  EXPECT_THAT(message("--nonsense"), testing::Not(testing::HasSubstr("command (")));
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

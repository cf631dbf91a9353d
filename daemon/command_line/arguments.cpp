#include "daemon/command_line/arguments.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <numeric>
#include <regex>
#include <utility>
#include <vector>

#include "drivers/text/printable.hpp"

namespace infuse::daemon {
namespace {

/// Number of letters to insert, remove or replace between two words (Levenshtein distance).
size_t edit_distance(const std::string& from, const std::string& to) {
  std::vector<size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < from.size(); ++i) {
    size_t diagonal = std::exchange(row[0], i + 1);
    for (size_t j = 0; j < to.size(); ++j) {
      const size_t replaced = diagonal + (from[i] == to[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

/// What is wrong with a first argument that is not a sub-command of a program that needs one.
std::optional<Error> find_wrong_subcommand(const CLI::App& app, const std::string& word) {
  const auto commands = app.get_subcommands([](const CLI::App*) { return true; });
  if (commands.empty() || word.starts_with('-')) return std::nullopt;
  const auto distance = [&](const CLI::App* command) {
    return edit_distance(word, command->get_name());
  };
  const CLI::App* nearest = *std::ranges::min_element(commands, {}, distance);
  if (distance(nearest) == 0) return std::nullopt;
  constexpr size_t kMaxTypingErrors = 2;
  return Error{"'" + word + "' is not a command", "",
               distance(nearest) <= kMaxTypingErrors ? "did you mean '" + nearest->get_name() + "'?"
                                                     : "--help lists the commands"};
}

/// The name of a program with that of the sub-command that was given: "infuse evaluate".
std::string name_with_subcommand(const CLI::App& app, const char* program) {
  std::string name = std::filesystem::path(program).filename().string();
  for (const CLI::App* at = &app; !at->get_subcommands().empty();) {
    at = at->get_subcommands().front();
    name += " " + at->get_name();
  }
  return name;
}

/// The items of "first->1,none->0": "first, none".
std::string items_of(const std::string& list) {
  return std::regex_replace(std::regex_replace(list, std::regex("->[^,]*"), ""), std::regex(","),
                            ", ");
}

/// The bounds that CLI11 states, "0.050000" and "100.000000": "between 0.05 and 100". Its positive
/// numbers reach to the largest double.
std::string bounds(const std::string& low, const std::string& high) {
  const double first = std::strtod(low.c_str(), nullptr), last = std::strtod(high.c_str(), nullptr);
  if (last == std::numeric_limits<double>::max()) return "above 0";
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "between %.10g and %.10g", first, last);
  return text.data();
}

/// What an option takes that cannot be converted from a text: whole numbers where it is a number.
std::string wanted_instead_of(const std::string& text) {
  char* end = nullptr;
  std::strtod(text.c_str(), &end);
  return text.empty() || *end != '\0' ? "a number" : "a whole number";
}

/// Lets options that count (type N in the help) refuse a minus, which CLI11 would take for a number
/// near 2⁶⁴.
void refuse_negative_counts(CLI::App& app) {
  for (CLI::Option* const option : app.get_options()) {
    const std::string type = option->get_type_name().substr(0, option->get_type_name().find(':'));
    if (type != "UINT" && type != "N") continue;
    option->check([](const std::string& text) {
      return text.starts_with('-') ? "must be at least 0, not '" + text + "'" : std::string();
    });
  }
  for (CLI::App* const command : app.get_subcommands([](const CLI::App*) { return true; })) {
    refuse_negative_counts(*command);
  }
}

/// What CLI11 says, as a sentence of ours.
std::string sentence_of(const std::string& said) {
  std::smatch match;
  if (std::regex_match(said, match, std::regex(R"((\S+): (.*) not in \{([^}]*)\}.*)")) ||
      std::regex_match(said, match, std::regex(R"((\S+): Check (.*) value in \{([^}]*)\}.*)"))) {
    return match.str(1) + " must be one of " + items_of(match.str(3)) + ", not '" + match.str(2) +
           "'";
  }
  if (std::regex_match(said, match, std::regex(R"((\S+): (.*) unit not recognized.*\{(.*)\})"))) {
    return match.str(1) + " has the unknown unit '" + match.str(2) +
           "'; known: " + items_of(match.str(3));
  }
  if (std::regex_match(said, match,
                       std::regex(R"((\S+): Value (.*) not in range (\S+) to (\S+))"))) {
    return match.str(1) + " must be " + bounds(match.str(3), match.str(4)) + ", not '" +
           match.str(2) + "'";
  }
  if (std::regex_match(said, match, std::regex(R"(Could not convert: (\S+) = (.*))")) ||
      std::regex_match(said, match, std::regex(R"((\S+): Value (.*) could not be converted.*)"))) {
    return match.str(1) + " must be " + wanted_instead_of(match.str(2)) + ", not '" + match.str(2) +
           "'";
  }
  if (std::regex_match(said, match, std::regex(R"((\S+): (must be .*))"))) {
    return match.str(1) + " " + match.str(2);
  }
  if (std::regex_match(said, match, std::regex(R"((\S+): 1 required .* missing)"))) {
    return match.str(1) + " needs a value";
  }
  if (std::regex_match(said, match,
                       std::regex("The following arguments? w.* not expected: (.*)"))) {
    return "unknown argument: " + match.str(1);
  }
  return said == "A subcommand is required" ? "no command is given" : said;
}

}  // namespace

std::optional<int> parse_arguments(CLI::App& app, int argc, char** argv) {
  refuse_negative_counts(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // help or version
    const auto wrong = find_wrong_subcommand(app, argc > 1 ? argv[1] : "-");
    return print_error(
        name_with_subcommand(app, argv[0]),
        wrong.value_or(Error{sentence_of(error.what()), "", "--help lists the options"}), kUsage);
  }
  return std::nullopt;
}

void set_examples(CLI::App& app, std::initializer_list<const char*> examples) {
  std::string text = "Examples:";
  for (const char* example : examples) text += std::string("\n  ") + example;
  app.footer(text);
}

int print_error(const std::string& program, const Error& error, ExitCode code) {
  const std::string message = text::printable(error.message(), "\n");
  std::fprintf(stderr, "%s: %s\n", program.c_str(), message.c_str());
  return code;
}

Result<std::optional<double>> parse_rate(const std::string& text) {
  if (text == "max") return std::optional<double>();
  char* end = nullptr;
  const double rate = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !(rate >= 0.01 && rate <= 1000)) {
    return fail("'" + text + "' is not a rate", "--rate",
                "give 0.01 ... 1000 (1 is real time), or max");
  }
  return std::optional<double>(rate);
}

}  // namespace infuse::daemon

#include "daemon/command_line/arguments.hpp"

#include <cstdio>
#include <cstdlib>

namespace infuse::daemon {

std::optional<int> parse_arguments(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  }
  return std::nullopt;
}

void set_examples(CLI::App& app, std::initializer_list<const char*> examples) {
  std::string text = "Examples:";
  for (const char* example : examples) text += std::string("\n  ") + example;
  app.footer(text);
}

int print_error(const std::string& program, const Error& error, ExitCode code) {
  std::fprintf(stderr, "%s: %s\n", program.c_str(), error.message().c_str());
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

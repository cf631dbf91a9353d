#include "drivers/recording/number_list.hpp"

#include <charconv>
#include <cmath>
#include <string>

#include "drivers/recording/candump_stamp.hpp"
#include "drivers/text/csv_reader.hpp"

namespace infuse::recording {

std::optional<std::vector<double>> parse_numbers(std::string_view text) {
  std::vector<double> numbers;
  constexpr std::string_view kBlanks = " \t\r";
  for (;;) {
    const size_t begin = text.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) return numbers;
    text.remove_prefix(begin);
    const size_t length = std::min(text.find_first_of(kBlanks), text.size());
    const auto number = parse_number(text.substr(0, length));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    text.remove_prefix(length);
  }
}

std::optional<Stamp> parse_seconds(std::string_view text) {
  std::string in_parentheses = "(";
  in_parentheses.append(text).append(")");
  if (const auto stamp = parse_candump_stamp(in_parentheses)) return stamp;
  const auto seconds = parse_number(text);
  if (!seconds || *seconds < 0 || *seconds > 9e9) return std::nullopt;
  return Stamp() + from_seconds(*seconds);
}

}  // namespace infuse::recording

#include "drivers/text/numbers.hpp"

#include <algorithm>
#include <limits>

namespace infuse::text {

double parse_number_or_nan(std::string_view text) {
  return parse_number(text).value_or(std::numeric_limits<double>::quiet_NaN());
}

std::string_view next_word(std::string_view& rest) {
  constexpr std::string_view kBlanks = " \t\r";
  rest.remove_prefix(std::min(rest.find_first_not_of(kBlanks), rest.size()));
  const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
  rest.remove_prefix(word.size());
  return word;
}

std::optional<std::vector<double>> parse_numbers(std::string_view text) {
  std::vector<double> numbers;
  for (std::string_view word; !(word = next_word(text)).empty();) {
    const auto number = parse_number(word);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace infuse::text

#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace infuse::text {

/// Parses the whole of `text` as a number, independent of the locale. Returns nothing if it is not
/// a number, is out of range or is not finite.
template <class Number>
std::optional<Number> parse_as(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if constexpr (std::is_floating_point_v<Number>) {
    if (!std::isfinite(value)) return std::nullopt;
  }
  return value;
}

/// Parses a floating-point number as `parse_as`.
inline std::optional<double> parse_number(std::string_view text) { return parse_as<double>(text); }

/// Parses an integer as `parse_as`.
inline std::optional<int64_t> parse_integer(std::string_view text) {
  return parse_as<int64_t>(text);
}

/// Parses a floating-point number; NaN if that fails.
double parse_number_or_nan(std::string_view text);

/// Removes the next word from `rest` and returns it; words are separated by spaces, tabs and
/// carriage returns. Empty at the end.
std::string_view next_word(std::string_view& rest);

/// Parses numbers separated by blanks. Returns nothing if one of them is invalid.
std::optional<std::vector<double>> parse_numbers(std::string_view text);

/// Appends the shortest digits that are parsed to the same number.
template <class Number>
void append_number(std::string& text, Number value) {
  std::array<char, 32> digits{};
  text.append(digits.data(),
              std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
}

}  // namespace infuse::text

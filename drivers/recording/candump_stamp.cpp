#include "drivers/recording/candump_stamp.hpp"

#include <charconv>

namespace infuse::recording {
namespace {

// Takes an integer of at most `most` digits from the front; gives how many there were, 0 for none.
size_t consume_digits(std::string_view& text, size_t max_digits, int64_t& value) {
  const size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
  if (digits == 0 || digits > max_digits) return 0;
  std::from_chars(text.data(), text.data() + digits, value);
  text.remove_prefix(digits);
  return digits;
}

}  // namespace

std::optional<Stamp> parse_candump_stamp(std::string_view line) {
  int64_t seconds = 0, fraction = 0;
  if (!line.starts_with('(')) return std::nullopt;
  line.remove_prefix(1);
  if (consume_digits(line, 9 + 1, seconds) == 0 || seconds > 9'000'000'000) return std::nullopt;
  if (line.starts_with('.')) {
    line.remove_prefix(1);
    const size_t digits = consume_digits(line, 9, fraction);
    if (digits == 0) return std::nullopt;
    for (size_t i = digits; i < 9; ++i) fraction *= 10;
  }
  if (!line.starts_with(')')) return std::nullopt;
  return Stamp::from_ns(seconds * 1'000'000'000 + fraction);
}

}  // namespace infuse::recording

#include "drivers/text/stamp_text.hpp"

#include <chrono>

#include "drivers/text/numbers.hpp"

namespace infuse::text {
namespace {

constexpr int64_t kNsPerSecond = 1'000'000'000;
constexpr double kMaxSeconds = 9e9;  // with an exponent

bool is_digits(std::string_view text) {
  return text.find_first_not_of("0123456789") == std::string_view::npos;
}

// "12.5" or "-12.5"; one of the two parts may be empty.
std::optional<Duration> parse_decimal_seconds(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  const size_t point = text.find('.');
  const std::string_view whole = text.substr(0, point);
  const std::string_view fraction =
      point == std::string_view::npos ? std::string_view() : text.substr(point + 1);
  if (!is_digits(whole) || !is_digits(fraction) || (whole.empty() && fraction.empty())) {
    return std::nullopt;
  }
  const auto seconds = whole.empty() ? std::optional<int64_t>(0) : parse_integer(whole);
  int64_t ns = 0;
  for (size_t i = 0; i < 9; ++i) ns = 10 * ns + (i < fraction.size() ? fraction[i] - '0' : 0);
  int64_t total = 0;
  if (!seconds || __builtin_mul_overflow(*seconds, kNsPerSecond, &total) ||
      __builtin_add_overflow(total, ns, &total)) {
    return std::nullopt;
  }
  return Duration(negative ? -total : total);
}

// "2018-08-02 16:14:48.230547"
std::optional<Duration> parse_date_and_time(std::string_view text) {
  if (text.size() < 19 || text[4] != '-' || text[7] != '-' || text[10] != ' ' || text[13] != ':' ||
      text[16] != ':') {
    return std::nullopt;
  }
  const auto part = [&](size_t at, size_t length) {
    return parse_as<unsigned>(text.substr(at, length)).value_or(9999);
  };
  const std::chrono::year_month_day day(std::chrono::year(static_cast<int>(part(0, 4))),
                                        std::chrono::month(part(5, 2)),
                                        std::chrono::day(part(8, 2)));
  const unsigned hour = part(11, 2), minute = part(14, 2), second = part(17, 2);
  const auto seconds = parse_decimal_seconds(text.substr(17));
  if (!day.ok() || hour > 23 || minute > 59 || second > 60 || !seconds) return std::nullopt;
  const auto days = std::chrono::sys_days(day).time_since_epoch();
  // Years beyond the range of 64-bit nanoseconds.
  if (days > std::chrono::days(100'000) || days < std::chrono::days(-100'000)) return std::nullopt;
  return Duration(days) + std::chrono::hours(hour) + std::chrono::minutes(minute) + *seconds;
}

}  // namespace

std::optional<Stamp> parse_stamp(std::string_view text) {
  std::optional<Duration> since_epoch;
  if (text.find(' ') != std::string_view::npos) {
    since_epoch = parse_date_and_time(text);
  } else if (text.find_first_of("eE") != std::string_view::npos) {
    const auto seconds = parse_number(text);
    if (seconds && std::abs(*seconds) <= kMaxSeconds) since_epoch = from_seconds(*seconds);
  } else {
    since_epoch = parse_decimal_seconds(text);
  }
  return since_epoch ? std::optional(Stamp() + *since_epoch) : std::nullopt;
}

}  // namespace infuse::text

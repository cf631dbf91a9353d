#include "drivers/gnss/nmea.hpp"

#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include "drivers/measurement/angles.hpp"
#include "drivers/text/numbers.hpp"

namespace infuse::gnss {
namespace {

constexpr double kKnot = 1852.0 / 3600.0;  // m/s
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr size_t kMaxFields = 24;

/// Comma-separated fields of a sentence between '$' and '*'.
struct Fields {
  std::array<std::string_view, kMaxFields> field{};
  size_t count = 0;

  std::string_view operator[](size_t i) const { return i < count ? field[i] : std::string_view(); }
};

Fields split(std::string_view body) {
  Fields fields;
  while (fields.count < kMaxFields) {
    const size_t comma = body.find(',');
    fields.field[fields.count++] = body.substr(0, comma);
    if (comma == std::string_view::npos) break;
    body.remove_prefix(comma + 1);
  }
  return fields;
}

/// Parses "ddmm.mmm" and its hemisphere. Returns radians.
std::optional<double> parse_angle(std::string_view text, std::string_view hemisphere,
                                  double limit) {
  const auto value = text::parse_number(text);
  if (!value || *value < 0 || hemisphere.size() != 1) return std::nullopt;
  const double degrees = std::floor(*value / 100);
  const double minutes = *value - degrees * 100;
  const double angle = (degrees + minutes / 60) * kDegree;
  if (minutes >= 60 || angle > limit) return std::nullopt;
  switch (hemisphere[0]) {
    case 'N':
    case 'E':
      return angle;
    case 'S':
    case 'W':
      return -angle;
    default:
      return std::nullopt;
  }
}

/// Parses "hhmmss[.sss]". Returns nanoseconds since midnight.
std::optional<int64_t> parse_time_of_day(std::string_view text) {
  if (text.size() < 6) return std::nullopt;
  const auto hours = text::parse_as<unsigned>(text.substr(0, 2));
  const auto minutes = text::parse_as<unsigned>(text.substr(2, 2));
  const auto seconds = text::parse_number(text.substr(4));
  if (!hours || !minutes || !seconds) return std::nullopt;
  if (*hours > 23 || *minutes > 59 || *seconds < 0 || *seconds >= 61) return std::nullopt;
  return static_cast<int64_t>(*hours * 60 + *minutes) * 60'000'000'000 +
         static_cast<int64_t>(std::llround(*seconds * 1e9));
}

/// Parses "ddmmyy" of the years 2000 … 2099. Returns days since the Unix epoch.
std::optional<std::chrono::sys_days> parse_date(std::string_view text) {
  if (text.size() != 6) return std::nullopt;
  const auto day = text::parse_as<unsigned>(text.substr(0, 2));
  const auto month = text::parse_as<unsigned>(text.substr(2, 2));
  const auto year = text::parse_as<int>(text.substr(4, 2));
  if (!day || !month || !year || *year < 0) return std::nullopt;
  const std::chrono::year_month_day date(std::chrono::year(2000 + *year),
                                         std::chrono::month(*month), std::chrono::day(*day));
  if (!date.ok()) return std::nullopt;
  return std::chrono::sys_days(date);
}

/// Reads latitude, its hemisphere, longitude and its hemisphere, starting at field `first`.
bool read_position(const Fields& fields, size_t first, GnssFix& fix) {
  const auto latitude = parse_angle(fields[first], fields[first + 1], 90 * kDegree);
  const auto longitude = parse_angle(fields[first + 2], fields[first + 3], 180 * kDegree);
  if (!latitude || !longitude) return false;
  fix.latitude = *latitude;
  fix.longitude = *longitude;
  return true;
}

tl::expected<NmeaFix, NmeaFault> read_rmc(const Fields& fields, NmeaFix result) {
  const auto time = parse_time_of_day(fields[1]);
  const auto day = parse_date(fields[9]);
  if (!time || !day) return tl::unexpected(NmeaFault::kField);
  result.fix.utc_ns = std::chrono::nanoseconds(day->time_since_epoch()).count() + *time;
  result.has_date = true;
  result.fix.valid = fields[2] == "A";
  if (!read_position(fields, 3, result.fix) && result.fix.valid) {
    return tl::unexpected(NmeaFault::kField);
  }
  result.fix.speed = text::parse_number_or_nan(fields[7]) * kKnot;
  result.fix.course = text::parse_number_or_nan(fields[8]) * kDegree;
  return result;
}

tl::expected<NmeaFix, NmeaFault> read_gga(const Fields& fields, NmeaFix result) {
  const auto time = parse_time_of_day(fields[1]);
  const auto quality = text::parse_as<unsigned>(fields[6]);
  if (!time || !quality) return tl::unexpected(NmeaFault::kField);
  result.fix.utc_ns = *time;
  result.fix.valid = *quality > 0;
  if (!read_position(fields, 2, result.fix) && result.fix.valid) {
    return tl::unexpected(NmeaFault::kField);
  }
  result.fix.hdop = text::parse_number_or_nan(fields[8]);
  result.fix.altitude = text::parse_number_or_nan(fields[9]);
  return result;
}

bool checksum_matches(std::string_view body, std::string_view digits) {
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  unsigned stated = 0;
  const auto [end, error] =
      std::from_chars(digits.data(), digits.data() + digits.size(), stated, 16);
  return error == std::errc() && digits.size() == 2 && end == digits.data() + 2 && stated == sum;
}

}  // namespace

const char* describe(NmeaFault fault) {
  switch (fault) {
    case NmeaFault::kNoSentence:
      return "not an NMEA sentence";
    case NmeaFault::kChecksum:
      return "NMEA checksum mismatch";
    case NmeaFault::kType:
      return "NMEA sentence is neither RMC nor GGA";
    case NmeaFault::kField:
      return "NMEA field is missing or not a number";
  }
  return "";
}

GnssFix stamped_fix(const NmeaFix& sentence, Stamp stamp) {
  GnssFix fix = sentence.fix;
  fix.stamp = stamp;
  if (!sentence.has_date) fix.utc_ns = 0;
  return fix;
}

tl::expected<NmeaFix, NmeaFault> parse_nmea(std::string_view text) {
  text = text.substr(0, text.find_first_of(std::string_view("\0\r\n", 3)));
  const size_t begin = text.find('$');
  const size_t star = text.find('*', begin == std::string_view::npos ? 0 : begin);
  if (begin == std::string_view::npos || star == std::string_view::npos) {
    return tl::unexpected(NmeaFault::kNoSentence);
  }
  const std::string_view body = text.substr(begin + 1, star - begin - 1);
  if (!checksum_matches(body, text.substr(star + 1, 2)))
    return tl::unexpected(NmeaFault::kChecksum);

  NmeaFix empty_fix;
  empty_fix.fix.altitude = kNaN;
  empty_fix.fix.speed = kNaN;
  empty_fix.fix.course = kNaN;
  empty_fix.fix.hdop = kNaN;
  const Fields fields = split(body);
  if (fields[0].size() != 5) return tl::unexpected(NmeaFault::kType);
  const std::string_view type = fields[0].substr(2);
  if (type == "RMC") return read_rmc(fields, empty_fix);
  if (type == "GGA") return read_gga(fields, empty_fix);
  return tl::unexpected(NmeaFault::kType);
}

}  // namespace infuse::gnss

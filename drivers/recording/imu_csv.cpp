#include "drivers/recording/imu_csv.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "drivers/measurement/angles.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::recording {
namespace {

constexpr std::array<CsvColumn, 7> kImuColumns = {
    {{"stamp_ns"}, {"wx"}, {"wy"}, {"wz"}, {"ax"}, {"ay"}, {"az"}}};

constexpr std::array<CsvColumn, 9> kGnssColumns = {{{"stamp_ns"},
                                                    {"latitude_deg"},
                                                    {"longitude_deg"},
                                                    {"altitude", false},
                                                    {"speed", false},
                                                    {"course_deg", false},
                                                    {"hdop", false},
                                                    {"utc_ns", false},
                                                    {"valid", false}}};

double parse_number_or_nan(std::string_view field) {
  return parse_number(field).value_or(std::numeric_limits<double>::quiet_NaN());
}

// An empty field stands for NaN.
void add_field(std::string& text, double value) {
  text += ',';
  if (std::isnan(value)) return;
  std::array<char, 32> digits{};
  text.append(digits.data(),
              std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
}

}  // namespace

Result<ImuCsv> ImuCsv::open(const std::filesystem::path& path) {
  auto csv = CsvReader::open(path, kImuColumns);
  if (!csv) return tl::unexpected(csv.error());
  return ImuCsv(std::move(*csv));
}

bool ImuCsv::next(ImuSample& sample) {
  std::array<std::string_view, kImuColumns.size()> fields;
  while (csv_.next(fields)) {
    const auto ns = parse_integer(fields[0]);
    std::array<double, 6> values{};
    bool whole = ns.has_value();
    for (size_t i = 0; i < values.size(); ++i) {
      values[i] = parse_number_or_nan(fields[i + 1]);
      whole = whole && !std::isnan(values[i]);
    }
    if (!whole) {
      csv_.reject("not all of stamp_ns, wx, wy, wz, ax, ay, az are numbers");
      continue;
    }
    sample.stamp = Stamp::from_ns(*ns);
    sample.angular_velocity = {values[0], values[1], values[2]};
    sample.linear_acceleration = {values[3], values[4], values[5]};
    return true;
  }
  return false;
}

Result<GnssCsv> GnssCsv::open(const std::filesystem::path& path) {
  auto csv = CsvReader::open(path, kGnssColumns);
  if (!csv) return tl::unexpected(csv.error());
  return GnssCsv(std::move(*csv));
}

bool GnssCsv::next(GnssFix& fix) {
  std::array<std::string_view, kGnssColumns.size()> fields;
  while (csv_.next(fields)) {
    const auto ns = parse_integer(fields[0]);
    const auto latitude = parse_number(fields[1]), longitude = parse_number(fields[2]);
    if (!ns || !latitude || !longitude || std::abs(*latitude) > 90 || std::abs(*longitude) > 360) {
      csv_.reject("no stamp, latitude (±90°) or longitude (±360°)");
      continue;
    }
    fix.stamp = Stamp::from_ns(*ns);
    fix.latitude = *latitude * kDegree;
    fix.longitude = *longitude * kDegree;
    fix.altitude = parse_number_or_nan(fields[3]);
    fix.speed = parse_number_or_nan(fields[4]);
    fix.course = parse_number_or_nan(fields[5]) * kDegree;
    fix.hdop = parse_number_or_nan(fields[6]);
    fix.utc_ns = parse_integer(fields[7]).value_or(0);
    fix.valid = fields[8].empty() || fields[8] == "1";
    return true;
  }
  return false;
}

Result<void> write_imu_csv(const std::filesystem::path& path,
                           const std::vector<ImuSample>& samples) {
  std::string text = "stamp_ns,wx,wy,wz,ax,ay,az\n";
  for (const ImuSample& sample : samples) {
    text += std::to_string(sample.stamp.ns());
    for (const double value : sample.angular_velocity) add_field(text, value);
    for (const double value : sample.linear_acceleration) add_field(text, value);
    text += '\n';
  }
  return write_text(path, text);
}

std::string format_gnss_row(const GnssFix& fix) {
  std::string text = std::to_string(fix.stamp.ns());
  for (const double value : {fix.latitude / kDegree, fix.longitude / kDegree, fix.altitude,
                             fix.speed, fix.course / kDegree, fix.hdop}) {
    add_field(text, value);
  }
  return text.append(",").append(std::to_string(fix.utc_ns)).append(fix.valid ? ",1\n" : ",0\n");
}

Result<void> write_gnss_csv(const std::filesystem::path& path, const std::vector<GnssFix>& fixes) {
  std::string text = kGnssCsvHeader;
  for (const GnssFix& fix : fixes) text += format_gnss_row(fix);
  return write_text(path, text);
}

}  // namespace infuse::recording

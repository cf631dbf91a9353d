#include "drivers/gnss/gnss_csv.hpp"

#include <array>
#include <cmath>

#include "drivers/measurement/angles.hpp"
#include "drivers/text/numbers.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::gnss {
namespace {

constexpr std::array<text::CsvColumn, 9> kColumns = {{{"stamp_ns"},
                                                      {"latitude_deg"},
                                                      {"longitude_deg"},
                                                      {"altitude", false},
                                                      {"speed", false},
                                                      {"course_deg", false},
                                                      {"hdop", false},
                                                      {"utc_ns", false},
                                                      {"valid", false}}};

}  // namespace

Result<GnssCsv> GnssCsv::open(const std::filesystem::path& path) {
  auto csv = text::CsvReader::open(path, kColumns);
  if (!csv) return tl::unexpected(csv.error());
  return GnssCsv(std::move(*csv));
}

bool GnssCsv::next(GnssFix& fix) {
  std::array<std::string_view, kColumns.size()> fields;
  while (csv_.next(fields)) {
    const auto ns = text::parse_integer(fields[0]);
    const auto latitude = text::parse_number(fields[1]), longitude = text::parse_number(fields[2]);
    if (!ns || !latitude || !longitude || std::abs(*latitude) > 90 || std::abs(*longitude) > 360) {
      csv_.reject("has no valid stamp, latitude (±90°) or longitude (±360°)");
      continue;
    }
    fix.stamp = Stamp::from_ns(*ns);
    fix.latitude = *latitude * kDegree;
    fix.longitude = *longitude * kDegree;
    fix.altitude = text::parse_number_or_nan(fields[3]);
    fix.speed = text::parse_number_or_nan(fields[4]);
    fix.course = text::parse_number_or_nan(fields[5]) * kDegree;
    fix.hdop = text::parse_number_or_nan(fields[6]);
    fix.utc_ns = text::parse_integer(fields[7]).value_or(0);
    fix.valid = fields[8].empty() || fields[8] == "1";
    return true;
  }
  return false;
}

std::string format_gnss_row(const GnssFix& fix) {
  std::string row = std::to_string(fix.stamp.ns());
  for (const double value : {fix.latitude / kDegree, fix.longitude / kDegree, fix.altitude,
                             fix.speed, fix.course / kDegree, fix.hdop}) {
    row += ',';
    if (!std::isnan(value)) text::append_number(row, value);
  }
  return row.append(",").append(std::to_string(fix.utc_ns)).append(fix.valid ? ",1\n" : ",0\n");
}

Result<void> write_gnss_csv(const std::filesystem::path& path, const std::vector<GnssFix>& fixes) {
  std::string rows = kGnssCsvHeader;
  for (const GnssFix& fix : fixes) rows += format_gnss_row(fix);
  return text::write_text(path, rows);
}

}  // namespace infuse::gnss

#include "drivers/recording/speed_csv.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "drivers/text/numbers.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::recording {
namespace {

constexpr std::array<text::CsvColumn, 3> kSpeedColumns = {
    {{"stamp_ns"}, {"speed"}, {"yaw_rate", false}}};

}  // namespace

Result<SpeedCsv> SpeedCsv::open(const std::filesystem::path& path) {
  auto csv = text::CsvReader::open(path, kSpeedColumns);
  if (!csv) return tl::unexpected(csv.error());
  return SpeedCsv(std::move(*csv));
}

bool SpeedCsv::next(WheelOdometry& sample) {
  constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();
  std::array<std::string_view, kSpeedColumns.size()> fields;
  while (csv_.next(fields)) {
    const auto ns = text::parse_integer(fields[0]);
    const auto speed = text::parse_number(fields[1]);
    const auto yaw_rate = text::parse_number(fields[2]);
    if (!ns || (!speed && (!yaw_rate || !fields[1].empty()))) {
      csv_.reject("not all of stamp_ns, speed are numbers");
      continue;
    }
    sample.stamp = Stamp::from_ns(*ns);
    sample.wheel_speed.fill(kNotMeasured);
    sample.yaw_rate = yaw_rate.value_or(kNotMeasured);
    sample.steering_angle = kNotMeasured;
    sample.speed = speed.value_or(kNotMeasured);
    return true;
  }
  return false;
}

Result<void> write_speed_csv(const std::filesystem::path& path,
                             const std::vector<WheelOdometry>& samples, bool with_yaw_rate) {
  std::string rows = with_yaw_rate ? "stamp_ns,speed,yaw_rate\n" : "stamp_ns,speed\n";
  for (const WheelOdometry& sample : samples) {
    rows += std::to_string(sample.stamp.ns()) + ",";
    if (std::isfinite(sample.speed)) text::append_number(rows, sample.speed);
    if (with_yaw_rate) rows += ',';
    if (with_yaw_rate && std::isfinite(sample.yaw_rate)) text::append_number(rows, sample.yaw_rate);
    rows += '\n';
  }
  return text::write_text(path, rows);
}

}  // namespace infuse::recording

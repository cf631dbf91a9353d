#include "drivers/recording/speed_csv.hpp"

#include <array>
#include <limits>

#include "drivers/text/numbers.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::recording {
namespace {

constexpr std::array<text::CsvColumn, 2> kSpeedColumns = {{{"stamp_ns"}, {"speed"}}};

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
    if (!ns || !speed) {
      csv_.reject("not all of stamp_ns, speed are numbers");
      continue;
    }
    sample.stamp = Stamp::from_ns(*ns);
    sample.wheel_speed.fill(kNotMeasured);
    sample.yaw_rate = sample.steering_angle = kNotMeasured;
    sample.speed = *speed;
    return true;
  }
  return false;
}

Result<void> write_speed_csv(const std::filesystem::path& path,
                             const std::vector<WheelOdometry>& samples) {
  std::string rows = "stamp_ns,speed\n";
  for (const WheelOdometry& sample : samples) {
    rows += std::to_string(sample.stamp.ns()) + ",";
    text::append_number(rows, sample.speed);
    rows += '\n';
  }
  return text::write_text(path, rows);
}

}  // namespace infuse::recording

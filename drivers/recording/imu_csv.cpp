#include "drivers/recording/imu_csv.hpp"

#include <array>

#include "drivers/text/numbers.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::recording {
namespace {

constexpr std::array<text::CsvColumn, 7> kColumns = {
    {{"stamp_ns"}, {"wx"}, {"wy"}, {"wz"}, {"ax"}, {"ay"}, {"az"}}};

}  // namespace

Result<ImuCsv> ImuCsv::open(const std::filesystem::path& path) {
  auto csv = text::CsvReader::open(path, kColumns);
  if (!csv) return tl::unexpected(csv.error());
  return ImuCsv(std::move(*csv));
}

bool ImuCsv::next(ImuSample& sample) {
  std::array<std::string_view, kColumns.size()> fields;
  while (csv_.next(fields)) {
    const auto ns = text::parse_integer(fields[0]);
    std::array<double, 6> values{};
    bool complete = ns.has_value();
    for (size_t i = 0; complete && i < values.size(); ++i) {
      const auto value = text::parse_number(fields[i + 1]);
      complete = value.has_value();
      values[i] = value.value_or(0);
    }
    if (!complete) {
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

Result<void> write_imu_csv(const std::filesystem::path& path,
                           const std::vector<ImuSample>& samples) {
  std::string rows = "stamp_ns,wx,wy,wz,ax,ay,az\n";
  const auto append = [&](const auto& values) {
    for (const double value : values) text::append_number(rows += ',', value);
  };
  for (const ImuSample& sample : samples) {
    rows += std::to_string(sample.stamp.ns());
    append(sample.angular_velocity);
    append(sample.linear_acceleration);
    rows += '\n';
  }
  return text::write_text(path, rows);
}

}  // namespace infuse::recording

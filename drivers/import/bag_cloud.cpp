#include "drivers/import/bag_cloud.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "drivers/recording/pcd_header.hpp"
#include "drivers/recording/pcd_sweep.hpp"
#include "drivers/recording/times_csv.hpp"

namespace infuse::importers {
namespace {

constexpr size_t kMaxCloudPoints = 4'000'000;
constexpr size_t kMaxCloudFields = 64;
constexpr size_t kMaxPointStep = 4096;
constexpr const char* kPadding = "_";

/// Type and size of a value as PCD files name them; size 0 if the type is unknown.
std::pair<char, size_t> type_of(uint8_t datatype) {
  switch (datatype) {
    case ros::PointField::kInt8:
      return {'I', 1};
    case ros::PointField::kUint8:
      return {'U', 1};
    case ros::PointField::kInt16:
      return {'I', 2};
    case ros::PointField::kUint16:
      return {'U', 2};
    case ros::PointField::kInt32:
      return {'I', 4};
    case ros::PointField::kUint32:
      return {'U', 4};
    case ros::PointField::kFloat32:
      return {'F', 4};
    case ros::PointField::kFloat64:
      return {'F', 8};
    default:
      return {'U', 0};
  }
}

void add_padding(recording::PcdHeader& header, size_t bytes) {
  if (bytes > 0)
    header.fields.push_back({.name = kPadding, .type = 'U', .size = 1, .count = bytes});
}

/// The layout of the points as that of a PCD file, gaps between fields included.
Result<recording::PcdHeader> header_of(const ros::PointCloud2& cloud) {
  recording::PcdHeader header;
  header.data = recording::PcdData::kBinary;
  header.points = static_cast<size_t>(cloud.height) * cloud.width;
  if (header.points > kMaxCloudPoints) return fail("has more than 4 million points");
  if (cloud.point_fields.size() > kMaxCloudFields || cloud.point_step > kMaxPointStep)
    return fail("has points of too many fields");
  std::vector<const ros::PointField*> fields;
  for (const ros::PointField& field : cloud.point_fields) fields.push_back(&field);
  std::ranges::stable_sort(fields, {}, &ros::PointField::offset);
  size_t at = 0;
  for (const ros::PointField* field : fields) {
    const auto [type, size] = type_of(field->datatype);
    const size_t count = std::max<size_t>(field->count, 1);
    if (size == 0 || field->offset < at || field->offset > cloud.point_step ||
        count > (cloud.point_step - field->offset) / size) {
      return fail("has a field '" + field->name + "' that does not fit its points");
    }
    add_padding(header, field->offset - at);
    header.fields.push_back({.name = field->name, .type = type, .size = size, .count = count});
    at = field->offset + size * count;
  }
  add_padding(header, cloud.point_step - at);
  return header;
}

/// The points without the bytes at the ends of rows.
Result<std::string_view> packed_points(const ros::PointCloud2& cloud, std::string& copy) {
  const size_t row = static_cast<size_t>(cloud.width) * cloud.point_step;
  const size_t row_step = cloud.height > 1 ? cloud.row_step : row;
  if (row_step < row || cloud.data.size() < row_step * cloud.height) {
    return fail("has " + std::to_string(cloud.data.size()) + " bytes where its layout needs " +
                std::to_string(std::max(row, row_step) * cloud.height));
  }
  const std::string_view data(reinterpret_cast<const char*>(cloud.data.data()), cloud.data.size());
  if (row_step == row) return data.substr(0, row * cloud.height);
  copy.clear();
  for (size_t k = 0; k < cloud.height; ++k) copy += data.substr(k * row_step, row);
  return std::string_view(copy);
}

struct CloudTimes {
  recording::TimeField field;
  Stamp stamp;  ///< of the sweep
};

/// The smallest of the values of returns; infinite if there are none.
double smallest(const recording::PcdHeader& header, std::string_view points, size_t field) {
  const auto values = recording::read_field(header, points, field);
  std::vector<double> squared(values.size(), 0);
  for (const char* axis : {"x", "y", "z"}) {
    const int index = header.find({axis});
    if (index < 0) continue;
    const auto coordinates = recording::read_field(header, points, static_cast<size_t>(index));
    for (size_t i = 0; i < values.size(); ++i) squared[i] += coordinates[i] * coordinates[i];
  }
  double first = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < values.size(); ++i) {
    if (squared[i] > 0 && std::isfinite(squared[i])) first = std::min(first, values[i]);
  }
  return first;
}

/// The field with the times of the returns, and what they count from.
std::optional<CloudTimes> find_times(const recording::PcdHeader& header, std::string_view points,
                                     Stamp stamp) {
  constexpr std::array<std::string_view, 6> kNames = {"t",          "time_offset_ns", "offset_time",
                                                      "time_stamp", "time",           "timestamp"};
  constexpr double kAbsoluteSeconds = 1e8, kAbsoluteNs = 1e17;  // since 1973
  for (const std::string_view name : kNames) {
    const int index = header.find({name});
    if (index < 0) continue;
    const double first = smallest(header, points, static_cast<size_t>(index));
    if (!std::isfinite(first)) continue;
    const bool whole = header.fields[static_cast<size_t>(index)].type != 'F';
    const bool absolute = first > (whole ? kAbsoluteNs : kAbsoluteSeconds);
    const double unit = whole || first > kAbsoluteNs ? 1 : 1e9;
    const double zero = absolute || first < 0 ? first : 0;
    CloudTimes times{{name, unit, zero}, stamp};
    const auto in_ns = Duration(static_cast<int64_t>(std::clamp(zero * unit, -9e18, 9e18)));
    times.stamp = absolute ? Stamp::from_ns(in_ns.count()) : stamp + in_ns;
    return times;
  }
  return std::nullopt;
}

}  // namespace

Result<void> to_sweep(const ros::PointCloud2& cloud, Stamp stamp, Sweep& sweep) {
  if (cloud.is_bigendian) return fail("is big-endian");
  const auto header = header_of(cloud);
  if (!header) return tl::unexpected(header.error());
  std::string copy;
  const auto points = packed_points(cloud, copy);
  if (!points) return tl::unexpected(points.error());
  const auto times = find_times(*header, *points, stamp);
  auto read = recording::parse_points(*header, *points, sweep,
                                      times ? times->field : recording::TimeField{});
  if (!read) return read;
  sweep.stamp = times ? times->stamp : stamp;
  sweep.span = Duration::zero();
  for (const int32_t offset : sweep.time_offset_ns)
    sweep.span = std::max(sweep.span, Duration(offset));
  return {};
}

}  // namespace infuse::importers

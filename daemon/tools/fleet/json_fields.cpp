#include "daemon/tools/fleet/json_fields.hpp"

#include <cmath>

#include "drivers/recording/rigid_matrix.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxFieldText = 500;  // bytes

}  // namespace

const Json& field_of(const Json& object, const char* key) {
  static const Json kAbsent;
  if (!object.is_object()) return kAbsent;
  const auto found = object.find(key);
  return found == object.end() ? kAbsent : *found;
}

std::string text_field(const Json& object, const char* key) {
  const Json& found = field_of(object, key);
  if (!found.is_string()) return {};
  std::string text = found.get_ref<const std::string&>().substr(0, kMaxFieldText);
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 127; }, ' ');
  return text;
}

std::optional<double> number_field(const Json& object, const char* key) {
  const Json& found = field_of(object, key);
  if (!found.is_number() || !std::isfinite(found.get<double>())) return std::nullopt;
  return found.get<double>();
}

std::optional<int64_t> integer_field(const Json& object, const char* key) {
  const Json& found = field_of(object, key);
  if (!found.is_number_integer()) return std::nullopt;
  if (found.is_number_unsigned() &&
      found.get<uint64_t>() > static_cast<uint64_t>(std::numeric_limits<int64_t>::max())) {
    return std::nullopt;
  }
  return found.get<int64_t>();
}

std::optional<Eigen::Isometry3d> motion_field(const Json& object, const char* key) {
  const Json& found = field_of(object, key);
  if (!found.is_array() || found.size() != 16) return std::nullopt;
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) {
    const Json& number = found[static_cast<size_t>(i)];
    if (!number.is_number() || !std::isfinite(number.get<double>())) return std::nullopt;
    matrix(i / 4, i % 4) = number.get<double>();
  }
  return recording::to_rigid(matrix);
}

std::optional<geometry::Matrix6> matrix_field(const Json& object, const char* key) {
  const Json& found = field_of(object, key);
  if (!found.is_array() || found.size() != 6) return std::nullopt;
  geometry::Matrix6 matrix;
  for (int r = 0; r < 6; ++r) {
    const Json& row = found[static_cast<size_t>(r)];
    if (!row.is_array() || row.size() != 6) return std::nullopt;
    for (int c = 0; c < 6; ++c) {
      const Json& number = row[static_cast<size_t>(c)];
      if (!number.is_number() || !std::isfinite(number.get<double>())) return std::nullopt;
      matrix(r, c) = number.get<double>();
    }
  }
  return geometry::Matrix6(0.5 * (matrix + matrix.transpose()));
}

Json motion_json(const Eigen::Isometry3d& T) {
  Json numbers = Json::array();
  for (int i = 0; i < 16; ++i) numbers.push_back(T.matrix()(i / 4, i % 4));
  return numbers;
}

Json rows_json(const geometry::Matrix6& matrix) {
  Json rows = Json::array();
  for (int r = 0; r < 6; ++r) rows.push_back(numbers_json(matrix.row(r).transpose()));
  return rows;
}

Json numbers_json(const geometry::Vector6& numbers) {
  Json list = Json::array();
  for (int k = 0; k < 6; ++k) list.push_back(numbers(k));
  return list;
}

}  // namespace infuse::daemon

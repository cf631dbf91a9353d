#include "daemon/tools/fleet/json_fields.hpp"

#include <cmath>

#include "daemon/protocol/number_json.hpp"
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
  const auto numbers = numbers_of(field_of(object, key), 16);
  return numbers ? recording::to_rigid(*numbers) : std::nullopt;
}

std::optional<geometry::Matrix6> matrix_field(const Json& object, const char* key) {
  const Json& found = field_of(object, key);
  if (!found.is_array() || found.size() != 6) return std::nullopt;
  geometry::Matrix6 matrix;
  for (size_t r = 0; r < 6; ++r) {
    const auto row = numbers_of(found[r], 6);
    if (!row) return std::nullopt;
    matrix.row(static_cast<Eigen::Index>(r)) = Eigen::Map<const geometry::Vector6>(row->data());
  }
  if (!matrix.allFinite()) return std::nullopt;
  return geometry::Matrix6(0.5 * (matrix + matrix.transpose()));
}

}  // namespace infuse::daemon

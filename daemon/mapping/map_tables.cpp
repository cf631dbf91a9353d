#include "daemon/mapping/map_tables.hpp"

#include <cmath>
#include <limits>

#include "drivers/measurement/angles.hpp"
#include "drivers/text/numbers.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kPoseColumns = "x_m,y_m,z_m,qx,qy,qz,qw";
constexpr const char* kFixesHeader =
    "stamp_ns,keyframe,latitude_deg,longitude_deg,altitude_m,hdop,x_m,y_m,z_m\n";

std::string covariance_columns() {
  std::string text;
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) text += ",c" + std::to_string(r) + std::to_string(c);
  }
  return text;
}

std::string keyframes_header() {
  return "keyframe,stamp_ns,way_m,points,cloud_checksum," + std::string(kPoseColumns) +
         covariance_columns() + "\n";
}

std::string closures_header() {
  return "from,to,guessed,agreement,overlap," + std::string(kPoseColumns) + covariance_columns() +
         ",reason\n";
}

void append_pose(std::string& text, const Eigen::Isometry3d& T) {
  Eigen::Quaterniond q(T.linear());
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  for (const double value : {T.translation().x(), T.translation().y(), T.translation().z(), q.x(),
                             q.y(), q.z(), q.w()}) {
    text::append_number(text += ',', value);
  }
}

void append_covariance(std::string& text, const geometry::Matrix6& C) {
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) text::append_number(text += ',', C(r, c));
  }
}

/// The columns of one row, from the left.
class Row {
 public:
  explicit Row(std::string_view line) : rest_(line) {}

  std::string_view word() {
    const size_t end = rest_.find(',');
    ended_ |= exhausted_;
    const std::string_view word = rest_.substr(0, end);
    exhausted_ = end == std::string_view::npos;
    rest_.remove_prefix(exhausted_ ? rest_.size() : end + 1);
    return word;
  }

  template <class Number>
  Number number() {
    const auto value = text::parse_as<Number>(word());
    wrong_ |= !value;
    return value.value_or(Number{});
  }

  Eigen::Isometry3d pose() {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    for (int axis = 0; axis < 3; ++axis) T.translation()[axis] = number<double>();
    Eigen::Quaterniond q;
    for (int i = 0; i < 4; ++i) q.coeffs()[i] = number<double>();
    constexpr double kQuaternionTolerance = 0.01;
    wrong_ |= !(std::abs(q.norm() - 1) < kQuaternionTolerance);
    if (!wrong_) T.linear() = q.normalized().toRotationMatrix();
    return T;
  }

  geometry::Matrix6 covariance() {
    geometry::Matrix6 C;
    for (int r = 0; r < 6; ++r) {
      for (int c = r; c < 6; ++c) C(r, c) = C(c, r) = number<double>();
    }
    return C;
  }

  /// What is left, commas included.
  std::string_view rest() {
    ended_ |= exhausted_;
    exhausted_ = true;
    return std::exchange(rest_, {});
  }

  /// True if every column was there and a number where one belongs, and none is left.
  bool complete() const { return exhausted_ && !ended_ && !wrong_; }

 private:
  std::string_view rest_;
  bool exhausted_ = false, ended_ = false, wrong_ = false;
};

/// Calls add(Row&) for every line after the header; it returns what is wrong, or an empty text.
template <class Add>
Result<void> parse_table(std::string_view text, std::string_view header, const std::string& name,
                         Add add) {
  if (!text.starts_with(header)) return fail("not such a table of a map", name + ":1");
  text.remove_prefix(header.size());
  for (size_t line = 2; !text.empty(); ++line) {
    const size_t end = text.find('\n');
    if (end == std::string_view::npos) {
      return fail("the last line is truncated", name + ":" + std::to_string(line));
    }
    Row row(text.substr(0, end));
    text.remove_prefix(end + 1);
    std::string wrong = add(row);
    if (!row.complete()) wrong = "not as many numbers as columns";
    if (!wrong.empty()) return fail(wrong, name + ":" + std::to_string(line));
  }
  return {};
}

}  // namespace

std::string format_keyframes(const std::vector<MapKeyframe>& keyframes) {
  std::string text = keyframes_header();
  for (size_t k = 0; k < keyframes.size(); ++k) {
    const mapping::Keyframe& keyframe = keyframes[k].keyframe;
    text::append_number(text, k);
    text::append_number(text += ',', keyframe.stamp.ns());
    text::append_number(text += ',', keyframe.distance_driven);
    text::append_number(text += ',', keyframes[k].points);
    text += ',' + keyframes[k].cloud_checksum;
    append_pose(text, keyframe.T_odom_vehicle);
    append_covariance(text, keyframe.covariance);
    text += '\n';
  }
  return text;
}

Result<std::vector<MapKeyframe>> parse_keyframes(std::string_view text, const std::string& name) {
  std::vector<MapKeyframe> keyframes;
  return parse_table(text, keyframes_header(), name,
                     [&](Row& row) -> std::string {
                       MapKeyframe parsed;
                       mapping::Keyframe& keyframe = parsed.keyframe;
                       const auto number = row.number<size_t>();
                       keyframe.stamp = Stamp::from_ns(row.number<int64_t>());
                       keyframe.distance_driven = row.number<double>();
                       parsed.points = row.number<size_t>();
                       parsed.cloud_checksum = row.word();
                       keyframe.has_cloud = !parsed.cloud_checksum.empty();
                       keyframe.T_odom_vehicle = row.pose();
                       keyframe.covariance = row.covariance();
                       if (number != keyframes.size()) return "keyframes are not in order";
                       if (!keyframes.empty() &&
                           keyframe.distance_driven < keyframes.back().keyframe.distance_driven) {
                         return "way goes back";
                       }
                       keyframes.push_back(std::move(parsed));
                       return "";
                     })
      .map([&] { return std::move(keyframes); });
}

std::string format_fixes(const std::vector<MapFix>& fixes) {
  std::string text = kFixesHeader;
  for (const MapFix& fix : fixes) {
    text::append_number(text, fix.fix.stamp.ns());
    text::append_number(text += ',', fix.keyframe);
    text::append_number(text += ',', fix.fix.latitude / kDegree);
    text::append_number(text += ',', fix.fix.longitude / kDegree);
    for (const double value : {fix.fix.altitude, fix.fix.hdop}) {
      text += ',';
      if (std::isfinite(value)) text::append_number(text, value);
    }
    for (const double value : fix.point) text::append_number(text += ',', value);
    text += '\n';
  }
  return text;
}

Result<std::vector<MapFix>> parse_fixes(std::string_view text, const std::string& name) {
  std::vector<MapFix> fixes;
  return parse_table(text, kFixesHeader, name,
                     [&](Row& row) -> std::string {
                       MapFix fix;
                       fix.fix.stamp = Stamp::from_ns(row.number<int64_t>());
                       fix.keyframe = row.number<size_t>();
                       fix.fix.latitude = row.number<double>() * kDegree;
                       fix.fix.longitude = row.number<double>() * kDegree;
                       fix.fix.altitude = text::parse_number_or_nan(row.word());
                       fix.fix.hdop = text::parse_number_or_nan(row.word());
                       for (double& value : fix.point) value = row.number<double>();
                       fix.fix.valid = true;
                       fixes.push_back(fix);
                       return "";
                     })
      .map([&] { return std::move(fixes); });
}

std::string format_closures(const std::vector<mapping::Closure>& closures) {
  std::string text = closures_header();
  for (const mapping::Closure& closure : closures) {
    text::append_number(text, closure.from);
    text::append_number(text += ',', closure.to);
    text += closure.guessed ? ",1" : ",0";
    text::append_number(text += ',', closure.agreement);
    text::append_number(text += ',', closure.overlap);
    append_pose(text, closure.T_from_to);
    append_covariance(text, closure.covariance);
    text += ',' + closure.reason + '\n';
  }
  return text;
}

Result<std::vector<mapping::Closure>> parse_closures(std::string_view text,
                                                     const std::string& name) {
  std::vector<mapping::Closure> closures;
  return parse_table(text, closures_header(), name,
                     [&](Row& row) -> std::string {
                       mapping::Closure closure;
                       closure.from = row.number<size_t>();
                       closure.to = row.number<size_t>();
                       closure.guessed = row.number<int>() != 0;
                       closure.agreement = row.number<double>();
                       closure.overlap = row.number<double>();
                       closure.T_from_to = row.pose();
                       closure.covariance = row.covariance();
                       closure.reason = row.rest();
                       if (closure.from >= closure.to) return "a closure leads forward";
                       closures.push_back(std::move(closure));
                       return "";
                     })
      .map([&] { return std::move(closures); });
}

}  // namespace infuse::daemon

#include "drivers/recording/trajectory_file.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "drivers/measurement/rotation.hpp"
#include "drivers/text/numbers.hpp"
#include "drivers/text/stamp_text.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::recording {
namespace {

constexpr size_t kMaxFields = 13;
constexpr double kTolerance = 0.01;

/// Fields of a line, separated by spaces, tabs or commas; at most `kMaxFields`.
struct Fields {
  std::array<std::string_view, kMaxFields> text;
  size_t count = 0;

  explicit Fields(std::string_view line) {
    constexpr const char* kSeparators = " \t\r,";
    size_t at = line.find_first_not_of(kSeparators);
    while (at != std::string_view::npos && count < kMaxFields) {
      const size_t end = std::min(line.find_first_of(kSeparators, at), line.size());
      text[count++] = line.substr(at, end - at);
      at = line.find_first_not_of(kSeparators, end);
    }
  }
};

/// Parses a number that may have a plus sign.
std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  return text::parse_number(text);
}

using LineParser = Result<TrajectoryPose> (*)(const Fields&, size_t index);

Result<std::vector<TrajectoryPose>> parse_lines(std::string_view text, const std::string& name,
                                                LineParser parse_line) {
  std::vector<TrajectoryPose> poses;
  size_t line_number = 0;
  while (!text.empty()) {
    const size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++line_number;
    const Fields fields(line);
    if (fields.count == 0 || fields.text[0].starts_with('#')) continue;
    auto pose = parse_line(fields, poses.size());
    if (pose && !poses.empty() && pose->stamp <= poses.back().stamp) {
      pose = fail("stamps must increase");
    }
    if (!pose) {
      Error error = pose.error();
      error.where = name + ":" + std::to_string(line_number);
      return tl::unexpected(error);
    }
    poses.push_back(*pose);
  }
  if (poses.empty())
    return fail("no pose", name, "expected lines of 8 (TUM) or 12 (KITTI) numbers");
  return poses;
}

Result<TrajectoryPose> parse_tum_line(const Fields& fields, size_t) {
  constexpr const char* kHint = "a TUM line is: seconds x y z qx qy qz qw";
  if (fields.count != 8) return fail(std::to_string(fields.count) + " numbers", "", kHint);
  const auto stamp = text::parse_stamp(fields.text[0]);
  std::array<double, 7> v{};
  for (size_t i = 0; i < 7; ++i) {
    const auto value = parse_number(fields.text[i + 1]);
    if (!value || !stamp) return fail("not a number, or not a time", "", kHint);
    v[i] = *value;
  }
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (std::abs(q.norm() - 1) > kTolerance)
    return fail("the norm of the quaternion is not 1", "", kHint);
  TrajectoryPose pose;
  pose.stamp = *stamp;
  pose.T_frame_body.linear() = q.normalized().toRotationMatrix();
  pose.T_frame_body.translation() << v[0], v[1], v[2];
  return pose;
}

Result<TrajectoryPose> parse_kitti_line(const Fields& fields, size_t index) {
  constexpr const char* kHint = "a KITTI line is the upper 3 x 4 part of a pose, by row";
  if (fields.count != 12) return fail(std::to_string(fields.count) + " numbers", "", kHint);
  Eigen::Matrix<double, 3, 4> m;
  for (int i = 0; i < 12; ++i) {
    const auto value = parse_number(fields.text[static_cast<size_t>(i)]);
    if (!value) return fail("not a number", "", kHint);
    m(i / 4, i % 4) = *value;
  }
  const Eigen::Matrix3d R = m.leftCols<3>();
  if (!(R * R.transpose()).isIdentity(kTolerance) || R.determinant() < 0) {
    return fail("not a rigid motion", "", kHint);
  }
  TrajectoryPose pose;
  pose.stamp = Stamp::from_ns(static_cast<int64_t>(index));
  pose.T_frame_body.linear() = orthonormal(R);
  pose.T_frame_body.translation() = m.col(3);
  return pose;
}

}  // namespace

Result<std::vector<TrajectoryPose>> parse_tum(std::string_view text, const std::string& name) {
  return parse_lines(text, name, parse_tum_line);
}

Result<std::vector<TrajectoryPose>> parse_kitti(std::string_view text, const std::string& name) {
  return parse_lines(text, name, parse_kitti_line);
}

Result<std::vector<TrajectoryPose>> read_trajectory(const std::filesystem::path& file) {
  constexpr size_t kMaxBytes = size_t{1} << 30;
  const auto content = text::read_text(file, kMaxBytes);
  if (!content) return tl::unexpected(content.error());
  std::string_view rest = *content;
  while (!rest.empty()) {
    const size_t end = rest.find('\n');
    const Fields fields(rest.substr(0, end));
    if (fields.count > 0 && !fields.text[0].starts_with('#')) {
      return fields.count == 12 ? parse_kitti(*content, file.string())
                                : parse_tum(*content, file.string());
    }
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  }
  return fail("no pose", file.string(), "expected lines of 8 (TUM) or 12 (KITTI) numbers");
}

std::string format_tum(const std::vector<TrajectoryPose>& poses) {
  std::string text;
  for (const TrajectoryPose& pose : poses) {
    const Eigen::Quaterniond q(pose.T_frame_body.linear());
    const auto t = pose.T_frame_body.translation();
    const int64_t ns = pose.stamp.ns();
    const bool negative = ns < 0;
    const uint64_t size = negative ? 0 - static_cast<uint64_t>(ns) : static_cast<uint64_t>(ns);
    char line[512];
    const int length =
        std::snprintf(line, sizeof line, "%s%llu.%09llu %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n",
                      negative ? "-" : "", static_cast<unsigned long long>(size / 1'000'000'000),
                      static_cast<unsigned long long>(size % 1'000'000'000), t.x(), t.y(), t.z(),
                      q.x(), q.y(), q.z(), q.w());
    text.append(line, std::min(static_cast<size_t>(length), sizeof line - 1));
  }
  return text;
}

std::string format_kitti(const std::vector<TrajectoryPose>& poses) {
  std::string text;
  for (const TrajectoryPose& pose : poses) {
    for (int i = 0; i < 12; ++i) {
      char number[64];
      const int length = std::snprintf(number, sizeof number, i < 11 ? "%.9e " : "%.9e\n",
                                       pose.T_frame_body.matrix()(i / 4, i % 4));
      text.append(number, static_cast<size_t>(length));
    }
  }
  return text;
}

}  // namespace infuse::recording

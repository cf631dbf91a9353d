#include "drivers/recording/poses_tum.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <string>

#include "drivers/recording/line_reader.hpp"
#include "drivers/recording/number_list.hpp"
#include "drivers/recording/text_file.hpp"

namespace infuse::recording {
namespace {

constexpr int64_t kNsPerSecond = 1'000'000'000;

void add(std::string& text, double value) {
  std::array<char, 32> digits{};
  text += ' ';
  text.append(digits.data(),
              std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
}

std::optional<StampedPose> parse_pose(std::string_view line) {
  const size_t space = line.find(' ');
  if (space == std::string_view::npos) return std::nullopt;
  const auto stamp = parse_seconds(line.substr(0, space));
  const auto numbers = parse_numbers(line.substr(space));
  if (!stamp || !numbers || numbers->size() != 7) return std::nullopt;
  const std::vector<double>& n = *numbers;
  const Eigen::Quaterniond rotation(n[6], n[3], n[4], n[5]);
  if (std::abs(rotation.norm() - 1) > 1e-3) return std::nullopt;
  StampedPose pose;
  pose.stamp = *stamp;
  pose.T_map_vehicle = Eigen::Translation3d(n[0], n[1], n[2]) * rotation.normalized();
  return pose;
}

}  // namespace

Result<void> write_poses_tum(const std::filesystem::path& path,
                             const std::vector<StampedPose>& poses) {
  std::string text = "# seconds tx ty tz qx qy qz qw (T_map_vehicle)\n";
  for (const StampedPose& pose : poses) {
    const int64_t ns = pose.stamp.ns();
    if (ns < 0) return fail("a pose lies before 1970", path.string());
    std::array<char, 32> seconds{};
    std::snprintf(seconds.data(), seconds.size(), "%lld.%09lld",
                  static_cast<long long>(ns / kNsPerSecond),
                  static_cast<long long>(ns % kNsPerSecond));
    text += seconds.data();
    const Eigen::Vector3d t = pose.T_map_vehicle.translation();
    const Eigen::Quaterniond q(pose.T_map_vehicle.rotation());
    for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) add(text, value);
    text += '\n';
  }
  return write_text(path, text);
}

Result<std::vector<StampedPose>> read_poses_tum(const std::filesystem::path& path) {
  auto lines = LineReader::open(path);
  if (!lines) return tl::unexpected(lines.error());
  std::vector<StampedPose> poses;
  std::string_view line;
  while (lines->next(line)) {
    if (line.empty() || line.front() == '#') continue;
    const auto pose = parse_pose(line);
    if (!pose) {
      return fail("is no pose", path.string() + ":" + std::to_string(lines->number()),
                  "seconds tx ty tz qx qy qz qw are expected");
    }
    poses.push_back(*pose);
  }
  return poses;
}

}  // namespace infuse::recording

#include "drivers/import/ford_files.hpp"

#include <charconv>
#include <cmath>

#include "drivers/import/ford_frames.hpp"
#include "drivers/measurement/rotation.hpp"

namespace infuse::importers {
namespace {

constexpr int64_t kEarliestUs = 946'684'800'000'000;  // 2000
constexpr int64_t kLatestUs = 2'147'483'647'000'000;  // 2038
constexpr double kMaxAngle = 6.4;                     // rad; beyond it they are degrees
constexpr double kMaxRotationError = 1e-3;

bool is_time(double us) {
  return us >= static_cast<double>(kEarliestUs) && us <= static_cast<double>(kLatestUs);
}

Stamp to_stamp_us(double us) { return Stamp::from_ns(static_cast<int64_t>(us) * 1000); }

const MatArray* find_variable(const std::map<std::string, MatArray>& variables,
                              const std::string& name) {
  const auto found = variables.find(name);
  return found == variables.end() ? nullptr : &found->second;
}

/// Six numbers as a pose, whatever their shape. False if they are no pose.
bool read_pose(const std::vector<double>& numbers, Eigen::Isometry3d& T) {
  if (numbers.size() != 6) return false;
  for (const double number : numbers) {
    if (!std::isfinite(number)) return false;
  }
  for (size_t k = 3; k < 6; ++k) {
    if (std::abs(numbers[k]) > kMaxAngle) return false;
  }
  T = ford_transform({numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5]});
  return true;
}

/// Vector k of `count` vectors of three, by columns or by rows.
Eigen::Vector3d vector_at(const MatArray& array, size_t k, size_t count) {
  const bool by_columns = array.rows == 3 && array.columns == count;
  return by_columns ? Eigen::Vector3d(array.at(0, k), array.at(1, k), array.at(2, k))
                    : Eigen::Vector3d(array.at(k, 0), array.at(k, 1), array.at(k, 2));
}

bool holds_vectors(const MatArray* array, size_t count) {
  if (array == nullptr || array->numbers.size() != 3 * count) return false;
  return (array->rows == 3 && array->columns == count) ||
         (array->rows == count && array->columns == 3);
}

bool skip_blanks_and_comments(std::string_view file, size_t& at) {
  while (at < file.size()) {
    if (file[at] == '#') {
      at = std::min(file.find('\n', at), file.size());
    } else if (std::isspace(static_cast<unsigned char>(file[at])) != 0) {
      ++at;
    } else {
      return true;
    }
  }
  return false;
}

std::optional<int> read_pnm_number(std::string_view file, size_t& at) {
  constexpr int kMaxPixels = 65'535;
  if (!skip_blanks_and_comments(file, at)) return std::nullopt;
  int value = 0;
  const auto [end, failed] = std::from_chars(file.data() + at, file.data() + file.size(), value);
  if (failed != std::errc{} || value <= 0 || value > kMaxPixels) return std::nullopt;
  at = static_cast<size_t>(end - file.data());
  return value;
}

}  // namespace

std::vector<Stamp> parse_ford_stamps(std::string_view text, const std::string& name,
                                     std::vector<Error>& notes) {
  std::vector<Stamp> stamps;
  size_t without = 0;
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    std::optional<Stamp> stamp;
    bool any = false;
    while (!line.empty()) {
      if (std::isdigit(static_cast<unsigned char>(line.front())) == 0) {
        any |= std::isspace(static_cast<unsigned char>(line.front())) == 0;
        line.remove_prefix(1);
        continue;
      }
      any = true;
      int64_t us = 0;
      const auto [rest, failed] = std::from_chars(line.data(), line.data() + line.size(), us);
      line.remove_prefix(static_cast<size_t>(rest - line.data()));
      if (failed == std::errc{} && us >= kEarliestUs && us <= kLatestUs && !stamp)
        stamp = Stamp::from_ns(us * 1000);
    }
    if (stamp) {
      stamps.push_back(*stamp);
    } else if (any) {
      ++without;
    }
  }
  if (without > 0)
    notes.push_back({std::to_string(without) + " lines have no time in µs", name, ""});
  return stamps;
}

Result<std::vector<FordCamera>> read_ford_cameras(const std::map<std::string, MatArray>& variables,
                                                  const std::string& name) {
  const MatArray* param = find_variable(variables, "PARAM");
  if (param == nullptr) return fail("has no variable PARAM", name);
  std::vector<FordCamera> cameras;
  for (size_t k = 0; param->field("K", k) != nullptr; ++k) {
    const MatArray& K = *param->field("K", k);
    const MatArray *R = param->field("R", k), *t = param->field("t", k);
    FordCamera camera{K.at(0, 0), K.at(1, 1), K.at(0, 2), K.at(1, 2)};
    if (!(camera.fx > 0) || !(camera.fy > 0) || !std::isfinite(camera.cx) ||
        !std::isfinite(camera.cy) || R == nullptr || t == nullptr || t->numbers.size() != 3)
      return fail("has no K, R and t of camera " + std::to_string(k), name);
    for (size_t row = 0; row < 3; ++row) {
      for (size_t column = 0; column < 3; ++column) {
        camera.T_camera_velodyne.linear()(static_cast<Eigen::Index>(row),
                                          static_cast<Eigen::Index>(column)) = R->at(row, column);
      }
      camera.T_camera_velodyne.translation()(static_cast<Eigen::Index>(row)) = t->numbers[row];
    }
    const Eigen::Matrix3d rotation = camera.T_camera_velodyne.linear();
    const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
    if (!(error < kMaxRotationError) || rotation.determinant() < 0 ||
        !camera.T_camera_velodyne.translation().allFinite())
      return fail("has an R of camera " + std::to_string(k) + " that is no rotation", name);
    camera.T_camera_velodyne.linear() = orthonormal(rotation);
    cameras.push_back(camera);
  }
  if (cameras.empty()) return fail("has no camera", name);
  return cameras;
}

Result<FordPose> read_ford_scan(const std::map<std::string, MatArray>& variables,
                                const std::string& name) {
  const MatArray* scan = find_variable(variables, "Scan");
  if (scan == nullptr) scan = find_variable(variables, "SCAN");
  if (scan == nullptr) return fail("has no variable Scan", name);
  const MatArray *time = scan->field("timestamp_laser"), *pose = scan->field("X_wv");
  if (time == nullptr || time->numbers.size() != 1 || !is_time(time->numbers[0]))
    return fail("has no timestamp_laser in µs", name);
  FordPose result{.stamp = to_stamp_us(time->numbers[0]),
                  .forward_speed = std::numeric_limits<double>::quiet_NaN()};
  if (pose == nullptr || !read_pose(pose->numbers, result.T_local_body))
    return fail("has no pose X_wv in m and rad", name);
  return result;
}

Result<std::vector<FordPose>> read_ford_poses(const std::map<std::string, MatArray>& variables,
                                              const std::string& name) {
  const MatArray* all = find_variable(variables, "Pose");
  if (all == nullptr) return fail("has no variable Pose", name);
  const MatArray* times = all->field("utime");
  const size_t count = times == nullptr ? 0 : times->numbers.size();
  const MatArray *pos = all->field("pos"), *rph = all->field("rph"), *vel = all->field("vel");
  if (count == 0 || !holds_vectors(pos, count) || !holds_vectors(rph, count) ||
      !holds_vectors(vel, count))
    return fail("has no utime, pos, rph and vel of the same length", name);
  std::vector<FordPose> poses;
  for (size_t k = 0; k < count; ++k) {
    const Eigen::Vector3d p = vector_at(*pos, k, count), r = vector_at(*rph, k, count);
    FordPose pose;
    if (!is_time(times->numbers[k]) ||
        !read_pose({p.x(), p.y(), p.z(), r.x(), r.y(), r.z()}, pose.T_local_body))
      return fail("has an impossible pose, number " + std::to_string(k), name);
    pose.stamp = to_stamp_us(times->numbers[k]);
    pose.forward_speed = pose.T_local_body.linear().col(0).dot(vector_at(*vel, k, count));
    if (!poses.empty() && pose.stamp <= poses.back().stamp) continue;
    poses.push_back(pose);
  }
  return poses;
}

std::optional<PnmHeader> read_pnm_header(std::string_view file) {
  if (!file.starts_with("P5") && !file.starts_with("P6")) return std::nullopt;
  PnmHeader header{.colour = file[1] == '6'};
  size_t at = 2;
  const auto width = read_pnm_number(file, at), height = read_pnm_number(file, at);
  const auto maximum = read_pnm_number(file, at);
  if (!width || !height || maximum != 255 || at >= file.size()) return std::nullopt;
  header.width = *width;
  header.height = *height;
  header.pixels = at + 1;  // one blank
  const size_t bytes = static_cast<size_t>(*width) * static_cast<size_t>(*height) *
                       (header.colour ? size_t{3} : size_t{1});
  if (header.pixels > file.size() || bytes > file.size() - header.pixels) return std::nullopt;
  return header;
}

}  // namespace infuse::importers

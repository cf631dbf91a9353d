#include "daemon/owner/report_truth.hpp"

#include <map>
#include <sstream>

#include "drivers/measurement/angles.hpp"
#include "drivers/recording/rigid_matrix.hpp"
#include "drivers/text/text_file.hpp"
#include "fusion/motion/trajectory_error.hpp"

namespace infuse::daemon {
namespace {

void add_position(Json& path, const Eigen::Isometry3d& T) {
  path["x"].push_back(T.translation().x());
  path["y"].push_back(T.translation().y());
}

/// A line of extrinsics.csv: stamp, camera, T_camera_lidar by row.
struct TrueExtrinsics {
  Stamp stamp;
  std::string camera;
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();
};

std::optional<TrueExtrinsics> parse_extrinsics(const std::string& line) {
  std::istringstream fields(line);
  int64_t ns = 0;
  char comma = 0;
  TrueExtrinsics extrinsics;
  if (!(fields >> ns >> comma) || !std::getline(fields, extrinsics.camera, ','))
    return std::nullopt;
  std::array<double, 16> numbers{};
  for (size_t i = 0; i < 16; ++i) {
    if (i > 0 && !(fields >> comma)) return std::nullopt;
    if (!(fields >> numbers[i])) return std::nullopt;
  }
  const auto T = recording::to_rigid(numbers);
  if (!T) return std::nullopt;
  extrinsics.stamp = Stamp::from_ns(ns);
  extrinsics.T_camera_lidar = *T;
  return extrinsics;
}

constexpr size_t kMaxTrueExtrinsics = size_t{64} << 20;  // bytes of the file
constexpr size_t kMaxTrueMoves = 100;
constexpr double kMinTrueRotation = 0.01 * kDegree;
constexpr double kMinTrueTranslation = 1e-3;  // m

}  // namespace

Json true_moves_json(const std::filesystem::path& drive, Stamp start) {
  Json moves = Json::array();
  const auto text = text::read_text(drive / "truth" / "extrinsics.csv", kMaxTrueExtrinsics);
  if (!text) return moves;
  std::map<std::string, Eigen::Isometry3d> last;
  std::istringstream lines(*text);
  for (std::string line; std::getline(lines, line) && moves.size() < kMaxTrueMoves;) {
    const auto now = parse_extrinsics(line);
    if (!now) continue;  // the heading
    const auto [before, is_first] = last.try_emplace(now->camera, now->T_camera_lidar);
    const CalibrationMove move = move_between(before->second, now->T_camera_lidar);
    if (is_first || (move.rotation < kMinTrueRotation && move.translation < kMinTrueTranslation)) {
      continue;
    }
    moves.push_back(
        {{"t", to_seconds(now->stamp - start)}, {"device", now->camera}, {"moved", to_json(move)}});
    before->second = now->T_camera_lidar;
  }
  return moves;
}

Json truth_json(const std::vector<recording::TrajectoryPose>& truth) {
  Thinned<Eigen::Isometry3d> kept;
  for (const auto& pose : truth) kept.add(pose.T_frame_body);
  Json path = {{"x", Json::array()}, {"y", Json::array()}};
  for (const Eigen::Isometry3d& T : kept.kept()) add_position(path, T);
  return path;
}

ComparedPath compare_with_truth(const std::vector<ReportedPose>& poses,
                                const std::vector<recording::TrajectoryPose>& truth,
                                bool move_first, Stamp start) {
  std::vector<geometry::StampedPose> estimate, true_poses;
  for (const auto& pose : poses) estimate.push_back({pose.stamp, pose.T_frame_vehicle});
  for (const auto& pose : truth) true_poses.push_back({pose.stamp, pose.T_frame_body});
  const std::vector<motion::PosePair> pairs = motion::pair_by_time(estimate, true_poses);
  if (pairs.empty()) return {};
  Eigen::Isometry3d T_truth_frame = Eigen::Isometry3d::Identity();
  if (move_first) T_truth_frame = pairs.front().truth * pairs.front().estimate.inverse();
  ComparedPath compared{
      {{"x", Json::array()}, {"y", Json::array()}},
      {{"t", Json::array()}, {"m", Json::array()}, {"horizontal_m", Json::array()}}};
  for (const auto& pose : estimate)
    add_position(compared.path, T_truth_frame * pose.T_odom_vehicle);
  for (const motion::PosePair& pair : pairs) {
    const Eigen::Vector3d apart =
        (T_truth_frame * pair.estimate).translation() - pair.truth.translation();
    compared.errors["t"].push_back(to_seconds(pair.stamp - start));
    compared.errors["m"].push_back(apart.norm());
    compared.errors["horizontal_m"].push_back(apart.head<2>().norm());
  }
  return compared;
}

}  // namespace infuse::daemon

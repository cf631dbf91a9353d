#include "drivers/import/turn_check.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/recording/sweep_files.hpp"
#include "fusion/geometry/trajectory.hpp"
#include "fusion/motion/deskew.hpp"

namespace infuse::importers {
namespace {

using recording::Turn;

constexpr size_t kSweeps = 25;
constexpr double kVoxel = 0.1;       // m
constexpr float kMaxRange = 25;      // m; beyond it returns are sparser than voxels
constexpr double kDecisive = 0.005;  // relative difference
constexpr double kMinGain = 0.5;     // of what the best alternative gains over not deskewing

// A way to give the returns times; absent turn: none, the sweep is taken as measured at its middle.
struct Hypothesis {
  std::optional<Turn> turn;
  std::string name;
  std::vector<uint64_t> voxels = {};

  size_t occupied() {
    std::sort(voxels.begin(), voxels.end());
    voxels.erase(std::unique(voxels.begin(), voxels.end()), voxels.end());
    return voxels.size();
  }
};

std::vector<Hypothesis> make_hypotheses(const Turn& turn) {
  std::vector<Hypothesis> all;
  all.push_back({turn, "as stated"});
  all.push_back({std::nullopt, "not deskewed"});
  all.push_back({Turn{!turn.clockwise, turn.cut_deg}, "in the other direction"});
  if (!turn.ring_cuts_deg.empty())
    all.push_back({Turn{turn.clockwise, turn.cut_deg}, "with one cut for all rings"});
  for (const int quarters : {1, 2, 3}) {
    const double cut = std::remainder(turn.cut_deg + 90 * quarters, 360);
    all.push_back({Turn{turn.clockwise, cut},
                   "with the cut at " + std::to_string(std::lround(cut)) + " deg"});
  }
  return all;
}

geometry::Trajectory make_trajectory(const std::vector<recording::TrajectoryPose>& path) {
  geometry::Trajectory trajectory({.capacity = std::max<size_t>(path.size(), 2)});
  for (const recording::TrajectoryPose& pose : path) {
    trajectory.append({.stamp = pose.stamp, .T_odom_vehicle = pose.T_frame_body});
  }
  return trajectory;
}

// Metres driven during a sweep, or nothing if the trajectory does not cover it.
std::optional<double> driven(const StampedFile& sweep, const geometry::Trajectory& trajectory) {
  if (!sweep.times.end) return std::nullopt;
  const auto motion = trajectory.between(sweep.times.stamp, *sweep.times.end);
  if (!motion.usable()) return std::nullopt;
  return motion.T_from_to.translation().norm();
}

// The run of consecutive sweeps, all covered, with the longest path.
std::vector<StampedFile> choose_sweeps(const std::vector<StampedFile>& sweeps,
                                       const geometry::Trajectory& trajectory) {
  std::vector<double> metres;
  for (const StampedFile& sweep : sweeps) metres.push_back(driven(sweep, trajectory).value_or(-1));
  size_t best = 0, best_count = 0;
  double longest = 0, sum = 0;
  for (size_t from = 0, to = 0; to < sweeps.size(); ++to) {
    if (metres[to] < 0) {
      from = to + 1;
      sum = 0;
      continue;
    }
    sum += metres[to];
    if (to - from == kSweeps) sum -= metres[from++];
    if (sum > longest) {
      longest = sum;
      best = from;
      best_count = to + 1 - from;
    }
  }
  const auto first = sweeps.begin() + static_cast<std::ptrdiff_t>(best);
  return {first, first + static_cast<std::ptrdiff_t>(best_count)};
}

uint64_t voxel_of(const Eigen::Vector3d& point) {
  uint64_t key = 0;
  for (int k = 0; k < 3; ++k) {
    const auto index = static_cast<int64_t>(std::floor(point[k] / kVoxel));
    key = key << 21 | (static_cast<uint64_t>(index) & 0x1FFFFF);
  }
  return key;
}

void add_voxels(Hypothesis& hypothesis, Sweep& sweep, const geometry::Trajectory& trajectory,
                const Eigen::Isometry3d& T_vehicle_lidar, motion::Deskewer& deskewer,
                motion::DeskewedSweep& deskewed) {
  const Stamp reference = sweep.stamp + sweep.span / 2;
  sweep.has_times = false;
  if (hypothesis.turn) assign_turn_times(*hypothesis.turn, sweep);
  deskewer.deskew(sweep, trajectory, reference, deskewed);
  const Eigen::Isometry3d T_odom_lidar = trajectory.at(reference).T_odom_vehicle * T_vehicle_lidar;
  for (size_t i = 0; i < sweep.size(); ++i) {
    if (sweep.range[i] > kMaxRange) continue;
    const Eigen::Vector3f point(deskewed.x[i], deskewed.y[i], deskewed.z[i]);
    hypothesis.voxels.push_back(voxel_of(T_odom_lidar * point.cast<double>()));
  }
}

}  // namespace

TurnCheck check_turn(const Turn& turn, const std::vector<StampedFile>& sweeps,
                     const std::vector<recording::TrajectoryPose>& path,
                     const Eigen::Isometry3d& T_vehicle_lidar) {
  using Verdict = TurnCheck::Verdict;
  const geometry::Trajectory trajectory = make_trajectory(path);
  const std::vector<StampedFile> chosen = choose_sweeps(sweeps, trajectory);
  if (chosen.size() < 2) return {Verdict::kUnknown, "the motion of the vehicle is not known"};
  std::vector<Hypothesis> hypotheses = make_hypotheses(turn);
  motion::Deskewer deskewer(T_vehicle_lidar);
  motion::DeskewedSweep deskewed;
  Sweep sweep;
  recording::SweepReader reader;
  for (const StampedFile& file : chosen) {
    if (!reader.read(file.path, sweep)) continue;
    sweep.stamp = file.times.stamp;
    sweep.span = *file.times.end - file.times.stamp;
    for (Hypothesis& hypothesis : hypotheses)
      add_voxels(hypothesis, sweep, trajectory, T_vehicle_lidar, deskewer, deskewed);
  }
  const double stated = static_cast<double>(hypotheses[0].occupied());
  const double none = static_cast<double>(hypotheses[1].occupied());
  const auto best =
      std::min_element(hypotheses.begin() + 1, hypotheses.end(),
                       [](Hypothesis& a, Hypothesis& b) { return a.occupied() < b.occupied(); });
  const double other = static_cast<double>(best->occupied());
  const auto number = [](double voxels) { return std::to_string(std::lround(voxels)); };
  const std::string counts = number(stated) + " occupied voxels, " + number(none) +
                             " not deskewed, " + number(other) + " " + best->name;
  const bool gains_less = none - stated < kMinGain * (none - other);
  if (gains_less && other < (1 - kDecisive) * stated) return {Verdict::kBlurs, counts};
  if (stated < (1 - kDecisive) * none) return {Verdict::kConfirmed, counts};
  return {Verdict::kUnknown, "the vehicle hardly moves: " + counts};
}

}  // namespace infuse::importers

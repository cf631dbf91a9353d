#include "fusion/calibration/scene_support.hpp"

#include <cmath>

#include "drivers/measurement/angles.hpp"

namespace infuse::calibration {
namespace {

constexpr size_t kMaxPointsPerScene = 8'000;  // maximum, mean over the scenes
constexpr size_t kMinPointsPerGroup = 2'000;  // with fewer the measure is mostly noise

double share_of_worse_rotations(Objective& measure, const Eigen::Isometry3d& T, double value) {
  int worse = 0;
  int compared = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double angle : {-2 * kDegree, -kDegree, kDegree, 2 * kDegree}) {
      const Eigen::Isometry3d wrong = geometry::exp(angle * geometry::Vector6::Unit(axis)) * T;
      worse += measure.evaluate(wrong, false).estimate.value < value ? 1 : 0;
      ++compared;
    }
  }
  return static_cast<double>(worse) / compared;
}

/// Groups of consecutive blocks with enough points; remaining blocks join the last group.
std::vector<std::span<const VisiblePoints::Block>> group_blocks(
    std::span<const VisiblePoints::Block> blocks) {
  std::vector<std::span<const VisiblePoints::Block>> out;
  size_t first = 0;
  for (size_t k = 0; k < blocks.size(); ++k) {
    if (blocks[k].end - blocks[first].begin < kMinPointsPerGroup) continue;
    out.push_back(blocks.subspan(first, k + 1 - first));
    first = k + 1;
  }
  if (first == blocks.size()) return out;
  const size_t from = out.empty() ? 0 : first - out.back().size();
  if (!out.empty()) out.pop_back();
  out.push_back(blocks.subspan(from));
  return out;
}

}  // namespace

std::vector<SceneSupport> scene_support(CoarseToFine& search,
                                        const Eigen::Isometry3d& T_refcam_lidar, size_t scenes,
                                        double sigma) {
  std::vector<SceneSupport> all(scenes);
  const VisiblePoints points = search.visible_points(T_refcam_lidar, scenes * kMaxPointsPerScene);
  for (const auto& together : group_blocks(points.blocks)) {
    const VisiblePoints own = select_blocks(points, together);
    SceneSupport shared;
    if (own.size() > 0) {
      Objective measure = search.make_objective(own, sigma);
      const dependence::Estimate estimate = measure.evaluate(T_refcam_lidar, false).estimate;
      shared.value = estimate.value;
      if (estimate.usable())
        shared.support = share_of_worse_rotations(measure, T_refcam_lidar, estimate.value);
    }
    for (const VisiblePoints::Block& block : together) {
      all[block.scene] = shared;
      all[block.scene].points = block.end - block.begin;
    }
  }
  return all;
}

}  // namespace infuse::calibration

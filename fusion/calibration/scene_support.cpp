#include "fusion/calibration/scene_support.hpp"

#include <cmath>

namespace infuse::calibration {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr size_t kMostEach = 8'000;  // points a scene, on the whole
constexpr size_t kFewest = 100;      // points: with fewer the measure is all noise

double share_of_worse(Objective& measure, const Eigen::Isometry3d& T, double value) {
  int worse = 0;
  int asked = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double angle : {-2 * kDegree, -kDegree, kDegree, 2 * kDegree}) {
      const Eigen::Isometry3d wrong = geometry::exp(angle * geometry::Vector6::Unit(axis)) * T;
      worse += measure.evaluate(wrong, false).estimate.value < value ? 1 : 0;
      ++asked;
    }
  }
  return static_cast<double>(worse) / asked;
}

}  // namespace

std::vector<SceneSupport> scene_support(CoarseToFine& search, const Eigen::Isometry3d& T_head_lidar,
                                        size_t scenes, double sigma) {
  std::vector<SceneSupport> all(scenes);
  const VisiblePoints points = search.visible(T_head_lidar, scenes * kMostEach);
  for (const VisiblePoints::Block& block : points.blocks) {
    SceneSupport& scene = all[block.scene];
    scene.points = block.end - block.begin;
    if (scene.points < kFewest) continue;
    const VisiblePoints own = only(points, block);
    Objective measure = search.objective(own, sigma);
    const dependence::Estimate estimate = measure.evaluate(T_head_lidar, false).estimate;
    scene.value = estimate.value;
    if (estimate.usable()) scene.support = share_of_worse(measure, T_head_lidar, estimate.value);
  }
  return all;
}

}  // namespace infuse::calibration

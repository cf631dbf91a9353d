#include "fusion/calibration/surface_normals.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>

#include "fusion/features/discontinuity.hpp"

namespace infuse::calibration {
namespace {

/// Adaptor of a sweep's points for nanoflann.
struct Cloud {
  const Sweep& sweep;

  size_t kdtree_get_point_count() const { return sweep.size(); }
  float kdtree_get_pt(size_t i, size_t axis) const {
    return axis == 0 ? sweep.x[i] : axis == 1 ? sweep.y[i] : sweep.z[i];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud>, Cloud, 3>;

/// Returns the direction in which the points spread least, facing the origin.
Eigen::Vector3f plane_normal(const Sweep& sweep, const std::vector<uint32_t>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  const Eigen::Vector3d first(sweep.x[points[0]], sweep.y[points[0]], sweep.z[points[0]]);
  for (const size_t i : points) {
    const Eigen::Vector3d p = Eigen::Vector3d(sweep.x[i], sweep.y[i], sweep.z[i]) - first;
    mean += p;
    squares += p * p.transpose();
  }
  const auto n = static_cast<double>(points.size());
  mean /= n;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread;
  spread.computeDirect(squares / n - mean * mean.transpose());
  const Eigen::Vector3d normal = spread.eigenvectors().col(0).normalized();
  return (normal.dot(first) > 0 ? -normal : normal).cast<float>();
}

}  // namespace

std::optional<std::string> NormalOptions::invalid() const {
  if (neighbours < 3 || neighbours > 10'000) return "neighbours must lie in 3 … 10000";
  if (!(max_neighbour_distance > 0)) return "max_neighbour_distance must be positive";
  return std::nullopt;
}

std::array<std::vector<float>, 3> surface_normals(const Sweep& sweep,
                                                  const NormalOptions& options) {
  std::array<std::vector<float>, 3> normals;
  for (auto& axis : normals) axis.assign(sweep.size(), features::kNotCompared);
  const auto neighbours = static_cast<size_t>(options.neighbours);
  if (sweep.size() < neighbours) return normals;
  const Cloud cloud{sweep};
  const Tree tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16));
  std::vector<uint32_t> found(neighbours);
  std::vector<float> squared(neighbours);
  const auto farthest =
      static_cast<float>(options.max_neighbour_distance * options.max_neighbour_distance);
  const size_t stride =
      options.max_normals == 0
          ? 1
          : std::max<size_t>(1, (sweep.size() + options.max_normals - 1) / options.max_normals);
  for (size_t i = 0; i < sweep.size(); i += stride) {
    const std::array<float, 3> at{sweep.x[i], sweep.y[i], sweep.z[i]};
    tree.knnSearch(at.data(), neighbours, found.data(), squared.data());
    if (!(squared.back() <= farthest)) continue;
    const Eigen::Vector3f normal = plane_normal(sweep, found);
    for (size_t axis = 0; axis < 3; ++axis) {
      normals[axis][i] = normal(static_cast<Eigen::Index>(axis));
    }
  }
  return normals;
}

}  // namespace infuse::calibration

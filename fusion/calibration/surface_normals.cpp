#include "fusion/calibration/surface_normals.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "fusion/features/discontinuity.hpp"
#include "fusion/features/neighbour_search.hpp"

namespace infuse::calibration {
namespace {

/// Returns the direction in which the points spread least, facing the origin.
Eigen::Vector3f plane_normal(const Sweep& sweep, std::span<const int32_t> points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  const auto point = [&](int32_t index) {
    const auto i = static_cast<size_t>(index);
    return Eigen::Vector3d(sweep.x[i], sweep.y[i], sweep.z[i]);
  };
  const Eigen::Vector3d first = point(points[0]);
  for (const int32_t i : points) {
    const Eigen::Vector3d p = point(i) - first;
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
  if (neighbours < 3 || neighbours > 10'000) return "neighbours must be between 3 and 10000";
  if (!(max_neighbour_distance > 0)) return "max_neighbour_distance must be positive";
  return std::nullopt;
}

std::array<std::vector<float>, 3> surface_normals(const Sweep& sweep,
                                                  const NormalOptions& options) {
  std::array<std::vector<float>, 3> normals;
  for (auto& axis : normals) axis.assign(sweep.size(), features::kNotCompared);
  const auto neighbours = static_cast<size_t>(options.neighbours);
  if (sweep.size() < neighbours) return normals;
  features::NeighbourSearch search;
  search.build({sweep.x, sweep.y, sweep.z});
  std::vector<int32_t> found(neighbours);
  std::vector<float> squared(neighbours);
  const auto farthest =
      static_cast<float>(options.max_neighbour_distance * options.max_neighbour_distance);
  const size_t stride =
      options.max_normals == 0
          ? 1
          : std::max<size_t>(1, (sweep.size() + options.max_normals - 1) / options.max_normals);
  for (size_t i = 0; i < sweep.size(); i += stride) {
    const std::array<float, 3> at{sweep.x[i], sweep.y[i], sweep.z[i]};
    constexpr float kAnywhere = std::numeric_limits<float>::infinity();
    const size_t count = search.nearest_points(at.data(), kAnywhere, found, squared);
    if (count < neighbours || squared.back() > farthest) continue;
    const Eigen::Vector3f normal = plane_normal(sweep, found);
    for (size_t axis = 0; axis < 3; ++axis) {
      normals[axis][i] = normal(static_cast<Eigen::Index>(axis));
    }
  }
  return normals;
}

}  // namespace infuse::calibration

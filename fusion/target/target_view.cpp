#include "fusion/target/target_view.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace infuse::target {

ReturnsPlane fit_returns_plane(const std::vector<BoardReturn>& returns) {
  ReturnsPlane plane;
  const auto n = static_cast<double>(returns.size());
  for (const BoardReturn& seen : returns) plane.mean += seen.point / n;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const BoardReturn& seen : returns) {
    scatter += (seen.point - plane.mean) * (seen.point - plane.mean).transpose() / n;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  plane.normal = eigen.eigenvectors().col(0);
  if (plane.normal.dot(plane.mean) > 0) plane.normal = -plane.normal;
  plane.width = std::sqrt(std::max(0.0, eigen.eigenvalues()(1)));
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector3d out =
        std::sqrt(2 * std::max(0.0, eigen.eigenvalues()(k + 1))) * eigen.eigenvectors().col(k + 1);
    plane.points.col(2 * k) = plane.mean + out;
    plane.points.col(2 * k + 1) = plane.mean - out;
  }
  return plane;
}

}  // namespace infuse::target

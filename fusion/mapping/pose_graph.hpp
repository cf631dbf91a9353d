#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

namespace infuse::mapping {

/// Number of degrees of freedom of a pose in D dimensions: 3 or 6.
template <int D>
inline constexpr int kPoseFreedom = D == 2 ? 3 : 6;

template <int D>
using Pose = Eigen::Transform<double, D, Eigen::Isometry>;

/// Matrix over the degrees of freedom of one pose.
template <int D>
using PoseMatrix = Eigen::Matrix<double, kPoseFreedom<D>, kPoseFreedom<D>>;

/// Measured motion between two poses of a graph.
template <int D>
struct PoseEdge {
  size_t from = 0, to = 0;                  ///< indices of poses
  Pose<D> T_from_to = Pose<D>::Identity();  ///< the motion
  /// Information as g2o has it, in the frame at `to`: (x, y, angle) in m and rad, or (x, y, z, qx,
  /// qy, qz) where q, the vector part of a unit quaternion, is half of a small rotation.
  PoseMatrix<D> information = PoseMatrix<D>::Identity();
  bool closure = false;  ///< a loop closure, which may be false; else odometry, which is trusted
};

/// Poses and the motions measured between them; D is 2 or 3.
template <int D>
struct PoseGraph {
  std::vector<Pose<D>> poses;      ///< T_map_pose
  std::vector<PoseEdge<D>> edges;  ///< in any order
};

/// First pose that no chain of edges joins to pose 0, or the number of poses if there is none.
template <int D>
size_t first_unconnected(const PoseGraph<D>& graph);

/// Sets all poses by composing edges from pose 0: along odometry as far as that leads, then along
/// as few closures as possible. Poses that are not connected keep their place.
template <int D>
void compose_odometry(PoseGraph<D>& graph);

/// Information in the order of `PoseEdge<3>` of a motion with a covariance of the left perturbation
/// in the frame at `from`, (rx, ry, rz, tx, ty, tz), rad and m; it is positive definite.
PoseMatrix<3> edge_information(const Pose<3>& T_from_to, const PoseMatrix<3>& covariance);

}  // namespace infuse::mapping

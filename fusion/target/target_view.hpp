#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "fusion/geometry/rigid_motion.hpp"

namespace infuse::target {

/// One board as both sensors saw it: what P(3.10) sums over.
struct TargetView {
  Eigen::Isometry3d T_refcam_board = Eigen::Isometry3d::Identity();
  /// Of a left perturbation of T_refcam_board.
  geometry::Matrix6 board_covariance = geometry::Matrix6::Zero();
  std::vector<Eigen::Vector3d> returns;  ///< on the board; m, lidar frame

  /// ʰN ÷ |ʰN| and |ʰN| of P(3.8): points x of the board have normal · x = distance.
  Eigen::Vector3d normal() const { return T_refcam_board.linear().col(2); }
  double distance() const { return normal().dot(T_refcam_board.translation()); }
};

/// The plane of a view's returns, and points on it that stand for them all.
struct ReturnsPlane {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();     ///< m, lidar frame
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< of the best plane, towards the lidar
  double rms = 0;    ///< m, distance of returns from that plane: the ranges' noise
  double width = 0;  ///< m, standard deviation of the returns along the plane's narrow side
  /// Four points with the returns' mean, and their scatter within the plane, each standing for a
  /// quarter of them: P(3.10) over either differs by what the ranges' noise brings alone.
  Eigen::Matrix<double, 3, 4> points = Eigen::Matrix<double, 3, 4>::Zero();
};

/// At least three returns are needed.
ReturnsPlane fit_returns_plane(const std::vector<Eigen::Vector3d>& returns);

}  // namespace infuse::target

#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "fusion/geometry/rigid_motion.hpp"
#include "fusion/target/board.hpp"

namespace infuse::target {

/// A return on a board, or near one.
struct BoardReturn {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< m, lidar frame
  uint16_t ring = 0;                                ///< its beam
  double reflectivity = 0;                          ///< as in a sweep
};

/// One board as seen by both sensors: a summand of P(3.10).
struct TargetView {
  Eigen::Isometry3d T_refcam_board = Eigen::Isometry3d::Identity();
  /// Covariance of a left perturbation of T_refcam_board.
  geometry::Matrix6 board_covariance = geometry::Matrix6::Zero();
  std::vector<BoardReturn> returns;  ///< returns on the board
  Board board;                       ///< its size

  /// ʰN ÷ |ʰN| and |ʰN| of P(3.8): points x on the board satisfy normal · x = distance.
  Eigen::Vector3d normal() const { return T_refcam_board.linear().col(2); }
  double distance() const { return normal().dot(T_refcam_board.translation()); }
};

/// Plane fitted to the returns of a view.
struct ReturnsPlane {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();     ///< m, lidar frame
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< of the fitted plane, towards the lidar
  double width = 0;  ///< m, standard deviation of the returns along the plane's narrow side
  /// Four points with the mean of the returns and their scatter within the plane, each representing
  /// a quarter of them.
  Eigen::Matrix<double, 3, 4> points = Eigen::Matrix<double, 3, 4>::Zero();
};

/// Fits a plane; needs at least three returns.
ReturnsPlane fit_returns_plane(const std::vector<BoardReturn>& returns);

}  // namespace infuse::target

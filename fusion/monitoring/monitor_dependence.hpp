#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "fusion/monitoring/monitor_view.hpp"

namespace infuse::monitoring {

/// Dependence between an image and a sweep at a pose, in nats per return: mutual information
/// P(3.17) of relative reflectivity and local grey plus that of depth edges and image edges, each
/// weighted by the number of its returns (n times the mutual information is a log-likelihood
/// ratio); image values are spread linearly over two of 16 bins. A cheap version of
/// `calibration::Objective`, of the order of 10 ns per point. Allocates nothing after the first
/// sweep of a size.
class MonitorDependence {
 public:
  /// Weights of the two parts; a lidar without reflectivity has depth edges alone (P 6.2.1).
  struct Weights {
    double reflectivity = 1;
    double edges = 1;
  };

  explicit MonitorDependence(const Weights& weights) : weights_(weights) {}

  /// Evaluates a pose near the one with which the points were selected. A point that leaves the
  /// image keeps the border's value, so that the measure cannot rise as points vanish.
  /// `coarse`: with the blurred image.
  double evaluate(const Eigen::Isometry3d& T_camera_lidar, const MonitorImage& image,
                  const MonitorPoints& points, const geometry::CameraModel& camera,
                  bool coarse = false);

 private:
  Weights weights_;
  std::vector<float> u_, v_, depth_;
};

}  // namespace infuse::monitoring

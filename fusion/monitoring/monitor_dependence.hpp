#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "fusion/monitoring/monitor_view.hpp"

namespace infuse::monitoring {

/// The dependence between a picture and a sweep at a pose, in nats a return: mutual information
/// P(3.17) of relative reflectivity and local grey plus that of depth edges and image edges, each
/// by the number of its returns, as n times it is a log-likelihood ratio; the picture's side spread
/// linearly over two of 16 bins. What `calibration::Objective` measures, made cheap: of
/// the order of 10 ns a point. Keeps its memory.
class MonitorDependence {
 public:
  /// What each part counts; a lidar without reflectivity has depth edges alone (P 6.2.1).
  struct Weights {
    double reflectivity = 1;
    double edges = 1;
  };

  explicit MonitorDependence(const Weights& weights) : weights_(weights) {}

  /// At a pose near to the one with which the points were picked; a point that leaves the picture
  /// keeps the border's value, so that it cannot raise the measure by vanishing.
  double evaluate(const Eigen::Isometry3d& T_camera_lidar, const MonitorImage& image,
                  const MonitorPoints& points, const geometry::CameraModel& camera);

 private:
  Weights weights_;
  std::vector<float> u_, v_, depth_;
};

}  // namespace infuse::monitoring

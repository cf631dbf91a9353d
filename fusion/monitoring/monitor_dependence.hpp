#pragma once

#include <Eigen/Geometry>
#include <cstdint>
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

  /// What returns outside the image count for: near the pose of their selection they keep the
  /// border's value, so that the measure changes smoothly; farther away, where many leave, they say
  /// nothing: many returns that share the border's few values seem to depend on it.
  enum class Outside : uint8_t { kBorder, kNothing };

  /// Evaluates a pose: nats over all returns, those outside included.
  double evaluate(const Eigen::Isometry3d& T_camera_lidar, const ComparedPlanes& planes,
                  const ComparedReturns& returns, const geometry::CameraModel& camera,
                  Outside outside = Outside::kBorder);

 private:
  Weights weights_;
  std::vector<float> u_, v_, depth_;
};

}  // namespace infuse::monitoring

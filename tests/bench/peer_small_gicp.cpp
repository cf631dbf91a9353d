#include "tests/bench/peer_small_gicp.hpp"

#include <small_gicp/ann/kdtree.hpp>
#include <small_gicp/factors/gicp_factor.hpp>
#include <small_gicp/points/point_cloud.hpp>
#include <small_gicp/registration/reduction.hpp>
#include <small_gicp/registration/registration.hpp>
#include <small_gicp/util/downsampling.hpp>
#include <small_gicp/util/normal_estimation.hpp>

namespace infuse::bench {

struct PeerSmallGicp::Clouds {
  small_gicp::PointCloud points[2];
  small_gicp::PointCloud::Ptr prepared[2];
  std::shared_ptr<small_gicp::KdTree<small_gicp::PointCloud>> tree[2];
};

PeerSmallGicp::PeerSmallGicp() : clouds_(std::make_unique<Clouds>()) {}
PeerSmallGicp::~PeerSmallGicp() = default;

void PeerSmallGicp::set_points(int which, const geometry::PointsView& points) {
  small_gicp::PointCloud& cloud = clouds_->points[which];
  cloud.resize(points.x.size());
  for (size_t i = 0; i < points.x.size(); ++i) {
    cloud.point(i) = Eigen::Vector4d(points.x[i], points.y[i], points.z[i], 1);
  }
}

size_t PeerSmallGicp::prepare(int which, double voxel_size, int neighbours) {
  clouds_->prepared[which] = small_gicp::voxelgrid_sampling(clouds_->points[which], voxel_size);
  small_gicp::PointCloud::Ptr& cloud = clouds_->prepared[which];
  clouds_->tree[which] = std::make_shared<small_gicp::KdTree<small_gicp::PointCloud>>(cloud);
  small_gicp::estimate_covariances(*cloud, *clouds_->tree[which], neighbours);
  return cloud->size();
}

size_t PeerSmallGicp::align(const double* T_target_source_guess, double max_distance,
                            double* T_target_source) {
  small_gicp::Registration<small_gicp::GICPFactor, small_gicp::SerialReduction> registration;
  registration.rejector.max_dist_sq = max_distance * max_distance;
  Eigen::Isometry3d guess;
  guess.matrix() = Eigen::Map<const Eigen::Matrix4d>(T_target_source_guess);
  const small_gicp::RegistrationResult result =
      registration.align(*clouds_->prepared[0], *clouds_->prepared[1], *clouds_->tree[0], guess);
  Eigen::Map<Eigen::Matrix4d>(T_target_source).noalias() = result.T_target_source.matrix();
  return result.iterations;
}

}  // namespace infuse::bench

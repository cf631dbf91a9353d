#include "fusion/target/view_consensus.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "drivers/measurement/median.hpp"

namespace infuse::target {
namespace {

// With half of the views right all fail once in 10²⁹ (Fischler and Bolles 1981).
constexpr int kTripleCount = 500;
constexpr double kMinNormalsVolume = 0.02;  // minimum volume spanned by three unit normals to count
                                            // as independent

/// Normal of the board towards the camera, as `ReturnsPlane::normal` points towards the lidar.
Eigen::Vector3d normal_towards_camera(const TargetView& view) {
  return view.distance() > 0 ? Eigen::Vector3d(-view.normal()) : view.normal();
}

std::optional<Eigen::Isometry3d> pose_from_three_views(std::span<const TargetView> views,
                                                       std::span<const ReturnsPlane> planes,
                                                       const std::array<size_t, 3>& chosen) {
  Eigen::Matrix3d refcam_normals, lidar_normals;
  for (int k = 0; k < 3; ++k) {
    const size_t i = chosen[static_cast<size_t>(k)];
    refcam_normals.col(k) = normal_towards_camera(views[i]);
    lidar_normals.col(k) = planes[i].normal;
  }
  if (std::abs(refcam_normals.determinant()) < kMinNormalsVolume) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(refcam_normals * lidar_normals.transpose(),
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  Eigen::Vector3d offsets;
  for (int k = 0; k < 3; ++k) {
    const size_t i = chosen[static_cast<size_t>(k)];
    const Eigen::Vector3d on_board = views[i].T_refcam_board.translation();
    offsets(k) = refcam_normals.col(k).dot(on_board - T.linear() * planes[i].mean);
  }
  T.translation() = refcam_normals.transpose().inverse() * offsets;
  return T;
}

double median_distance(std::span<const TargetView> views, std::span<const ReturnsPlane> planes,
                       const Eigen::Isometry3d& T, std::vector<double>& scratch) {
  scratch.clear();
  for (size_t i = 0; i < views.size(); ++i) {
    scratch.push_back(rms_board_distance(views[i], planes[i], T));
  }
  return median(scratch);
}

}  // namespace

double rms_board_distance(const TargetView& view, const ReturnsPlane& plane,
                          const Eigen::Isometry3d& T_refcam_lidar) {
  double squares = 0;
  for (int k = 0; k < 4; ++k) {
    const double off = view.normal().dot(T_refcam_lidar * plane.points.col(k)) - view.distance();
    squares += off * off / 4;
  }
  return std::sqrt(squares);
}

std::optional<Eigen::Isometry3d> find_consensus_pose(std::span<const TargetView> views,
                                                     std::span<const ReturnsPlane> planes,
                                                     uint64_t seed) {
  if (views.size() < 3) return std::nullopt;
  std::mt19937_64 random(seed);
  std::optional<Eigen::Isometry3d> best;
  double best_median = 0;
  std::vector<double> scratch;
  for (int k = 0; k < kTripleCount; ++k) {
    const std::array<size_t, 3> chosen = {random() % views.size(), random() % views.size(),
                                          random() % views.size()};
    const auto T = pose_from_three_views(views, planes, chosen);
    if (!T) continue;
    const double median = median_distance(views, planes, *T, scratch);
    if (!best || median < best_median) {
      best_median = median;
      best = T;
    }
  }
  return best;
}

}  // namespace infuse::target

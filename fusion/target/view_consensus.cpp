#include "fusion/target/view_consensus.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace infuse::target {
namespace {

constexpr int kDraws = 500;
constexpr double kLeastVolume = 0.02;  // of three unit normals: they are independent

/// The board's normal towards the camera, as `ReturnsPlane::normal` is towards the lidar.
Eigen::Vector3d facing(const TargetView& view) {
  return view.distance() > 0 ? Eigen::Vector3d(-view.normal()) : view.normal();
}

std::optional<Eigen::Isometry3d> from_three(std::span<const TargetView> views,
                                            std::span<const ReturnsPlane> planes,
                                            const std::array<size_t, 3>& chosen) {
  Eigen::Matrix3d head, lidar;
  for (int k = 0; k < 3; ++k) {
    const size_t i = chosen[static_cast<size_t>(k)];
    head.col(k) = facing(views[i]);
    lidar.col(k) = planes[i].normal;
  }
  if (std::abs(head.determinant()) < kLeastVolume) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(head * lidar.transpose(),
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  Eigen::Vector3d left;
  for (int k = 0; k < 3; ++k) {
    const size_t i = chosen[static_cast<size_t>(k)];
    const Eigen::Vector3d on_board = views[i].T_head_board.translation();
    left(k) = head.col(k).dot(on_board - T.linear() * planes[i].mean);
  }
  T.translation() = head.transpose().inverse() * left;
  return T;
}

double median_distance(std::span<const TargetView> views, std::span<const ReturnsPlane> planes,
                       const Eigen::Isometry3d& T, std::vector<double>& scratch) {
  scratch.clear();
  for (size_t i = 0; i < views.size(); ++i) {
    scratch.push_back(board_distance(views[i], planes[i], T));
  }
  const auto middle = scratch.begin() + static_cast<std::ptrdiff_t>(scratch.size() / 2);
  std::nth_element(scratch.begin(), middle, scratch.end());
  return *middle;
}

}  // namespace

double board_distance(const TargetView& view, const ReturnsPlane& plane,
                      const Eigen::Isometry3d& T_head_lidar) {
  double squares = 0;
  for (int k = 0; k < 4; ++k) {
    const double off = view.normal().dot(T_head_lidar * plane.points.col(k)) - view.distance();
    squares += off * off / 4;
  }
  return std::sqrt(squares);
}

std::optional<Eigen::Isometry3d> view_consensus(std::span<const TargetView> views,
                                                std::span<const ReturnsPlane> planes,
                                                uint64_t seed) {
  if (views.size() < 3) return std::nullopt;
  std::mt19937_64 random(seed);
  std::optional<Eigen::Isometry3d> best;
  double least = 0;
  std::vector<double> scratch;
  for (int k = 0; k < kDraws; ++k) {
    const std::array<size_t, 3> chosen = {random() % views.size(), random() % views.size(),
                                          random() % views.size()};
    const auto T = from_three(views, planes, chosen);
    if (!T) continue;
    const double median = median_distance(views, planes, *T, scratch);
    if (!best || median < least) {
      least = median;
      best = T;
    }
  }
  return best;
}

}  // namespace infuse::target

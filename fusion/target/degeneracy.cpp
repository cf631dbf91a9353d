#include "fusion/target/degeneracy.hpp"

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <cstdio>

#include "drivers/measurement/angles.hpp"

namespace infuse::target {
namespace {

constexpr double kCoplanarSinSquared = 0.0027;  // sin² of 3 degrees

std::string format_direction(const char* format, const Eigen::Vector3d& direction) {
  // The sign of the direction is arbitrary: make its largest entry positive.
  int largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  const Eigen::Vector3d d = direction(largest) < 0 ? Eigen::Vector3d(-direction) : direction;
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(), format, d.x(), d.y(), d.z());
  return text.data();
}

}  // namespace

std::string describe_degeneracy(std::span<const TargetView* const> views) {
  if (views.empty()) return "no usable view of a board";
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const TargetView* view : views) {
    spread += view->normal() * view->normal().transpose() / static_cast<double>(views.size());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread);
  if (eigen.eigenvalues()(1) < kCoplanarSinSquared) {
    return format_direction(
        "all normals are parallel: translation across and rotation about (%.1f, %.1f, %.1f) are "
        "free; show the board in at least three orientations",
        eigen.eigenvectors().col(2));
  }
  if (eigen.eigenvalues()(0) < kCoplanarSinSquared) {
    return format_direction(
        "all normals lie in one plane: translation along (%.1f, %.1f, %.1f) is free; tilt the "
        "board that way",
        eigen.eigenvectors().col(0));
  }
  return {};
}

std::string describe_uncertain_axis(const geometry::Matrix6& covariance, double rotation,
                                    double translation) {
  constexpr std::array<const char*, 6> kAxes = {"rotation about x",    "rotation about y",
                                                "rotation about z",    "translation along x",
                                                "translation along y", "translation along z"};
  for (int k = 0; k < 6; ++k) {
    const double sigma = std::sqrt(covariance(k, k));
    if (sigma <= (k < 3 ? rotation : translation)) continue;
    std::array<char, 128> text{};
    std::snprintf(text.data(), text.size(), "%s is only known to %.2g %s; add more views",
                  kAxes[static_cast<size_t>(k)], k < 3 ? sigma / kDegree : sigma,
                  k < 3 ? "degrees" : "m");
    return text.data();
  }
  return {};
}

}  // namespace infuse::target

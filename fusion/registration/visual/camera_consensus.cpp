#include "fusion/registration/visual/camera_consensus.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fusion/geometry/camera_model.hpp"

namespace infuse::registration {
namespace {

constexpr int kHeadings = 36;       // of the rig, and of the points around it
constexpr int kMoves = 8;           // directions of a translation
constexpr double kDistance = 15;    // m, of the scene
constexpr double kMinShare = 0.25;  // of what a camera sees

/// True if the camera sees a point, lidar frame.
bool sees(const geometry::CameraModel& model, const CameraMount& camera,
          const Eigen::Vector3d& point) {
  const Eigen::Vector3d p = camera.T_camera_lidar * point;
  if (p.z() <= 0 && camera.intrinsics.model == CameraIntrinsics::Model::kPinhole) return false;
  const auto pixel = model.project(p);
  return pixel && model.in_image(*pixel);
}

}  // namespace

std::vector<ConsensusMatrix> ideal_consensus(std::span<const CameraMount> cameras) {
  if (cameras.empty()) return {};
  std::vector<geometry::CameraModel> models;
  for (const CameraMount& camera : cameras) models.emplace_back(camera.intrinsics);
  const auto count = static_cast<Eigen::Index>(cameras.size());
  const auto turn = [](int step, int steps) { return 2 * std::numbers::pi * step / steps; };
  constexpr int kPoints = 4 * kHeadings;
  std::vector<ConsensusMatrix> ideal;
  for (int heading = 0; heading < kHeadings; ++heading) {
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(turn(heading, kHeadings), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    for (int move = 0; move <= kMoves; ++move) {
      Eigen::Vector3d t = Eigen::Vector3d::Zero();  // the source's place in the target's frame
      if (move > 0) {
        t = kDistance / 2 *
            Eigen::Vector3d(std::cos(turn(move, kMoves)), std::sin(turn(move, kMoves)), 0);
      }
      ConsensusMatrix common = ConsensusMatrix::Zero(count, count);
      Eigen::VectorXd seen = Eigen::VectorXd::Zero(count);  // by each camera of the source
      for (int k = 0; k < kPoints; ++k) {
        const Eigen::Vector3d point =
            kDistance * Eigen::Vector3d(std::cos(turn(k, kPoints)), std::sin(turn(k, kPoints)), 0);
        const Eigen::Vector3d in_source = R.transpose() * (point - t);
        for (Eigen::Index j = 0; j < count; ++j) {
          const auto sj = static_cast<size_t>(j);
          if (!sees(models[sj], cameras[sj], in_source)) continue;
          seen(j) += 1;
          for (Eigen::Index i = 0; i < count; ++i) {
            const auto si = static_cast<size_t>(i);
            if (sees(models[si], cameras[si], point)) common(i, j) += 1;
          }
        }
      }
      ConsensusMatrix matrix = ConsensusMatrix::Zero(count, count);
      for (Eigen::Index i = 0; i < count; ++i) {
        for (Eigen::Index j = 0; j < count; ++j) {
          if (common(i, j) > 0 && common(i, j) >= kMinShare * seen(j)) matrix(i, j) = 1;
        }
      }
      if (matrix.maxCoeff() > 0 && std::find(ideal.begin(), ideal.end(), matrix) == ideal.end()) {
        ideal.push_back(matrix);
      }
    }
  }
  // Cameras that see nothing at that distance may still share something.
  if (ideal.empty()) ideal.push_back(ConsensusMatrix::Ones(count, count));
  return ideal;
}

ConsensusMatrix normalise_rows(const ConsensusMatrix& measured) {
  ConsensusMatrix scaled = measured;
  for (Eigen::Index i = 0; i < scaled.rows(); ++i) {
    const double largest = scaled.row(i).maxCoeff();
    if (largest > 0) scaled.row(i) /= largest;
  }
  return scaled;
}

size_t nearest_consensus(const ConsensusMatrix& measured, std::span<const ConsensusMatrix> ideal) {
  size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (size_t k = 0; k < ideal.size(); ++k) {
    const double along = measured.cwiseProduct(ideal[k]).sum() / ideal[k].squaredNorm();
    const double distance = (measured - along * ideal[k]).norm();
    if (distance < least) {
      least = distance;
      best = k;
    }
  }
  return best;
}

}  // namespace infuse::registration

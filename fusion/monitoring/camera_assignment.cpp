#include "fusion/monitoring/camera_assignment.hpp"

#include <algorithm>

namespace infuse::monitoring {
namespace {

size_t index_of(size_t a, size_t b) {
  const size_t larger = std::max(a, b);
  return larger * (larger - 1) / 2 + std::min(a, b);
}

}  // namespace

CameraAssignment::CameraAssignment(const std::vector<PlacedCamera>& rig,
                                   const DriftDetectorOptions& options,
                                   const MonitorDependence::Weights& weights, size_t max_points)
    : pairs_(rig.size() * (rig.size() + 1) / 2),
      threshold_(options.confirmation_threshold()),
      most_(options.max_evidence_per_evaluation),
      max_points_(max_points),
      dependence_(weights) {
  rig_.reserve(rig.size());
  for (const PlacedCamera& camera : rig) {
    Placed& placed = rig_.emplace_back(
        Placed{camera.name, geometry::CameraModel(camera.intrinsics), camera.T_camera_lidar, {}});
    for (size_t k = 0; k < rig.size(); ++k) {
      const CameraIntrinsics& other = rig[k].intrinsics;
      if (&rig[k] != &camera && rig[k].lidar == camera.lidar &&
          other.width == camera.intrinsics.width && other.height == camera.intrinsics.height) {
        placed.others.push_back({.camera = k});
      }
    }
  }
}

void CameraAssignment::set_place(size_t camera, const Eigen::Isometry3d& T_camera_lidar) {
  rig_[camera].T_camera_lidar = T_camera_lidar;
  for (Other& other : rig_[camera].others) {
    // What waits was compared at the former place.
    other.waits = false;
    if (Other* back = find(other.camera, camera)) back->waits = false;
  }
}

void CameraAssignment::add(size_t camera, const ComparedPlanes& planes, const SweepView& sweep,
                           double own, const MonitorPoints& points, double noise) {
  Placed& placed = rig_[camera];
  if (placed.others.empty() || points.size() == 0 || !(noise > 0)) return;
  Other& other = placed.others[placed.next];
  placed.next = (placed.next + 1) % placed.others.size();
  const Placed& there = rig_[other.camera];
  points_.select(sweep, points, there.model, there.T_camera_lidar, max_points_);
  const auto count = static_cast<double>(points.size());
  other.gain =
      static_cast<double>(points_.size()) *
          dependence_.evaluate(there.T_camera_lidar, planes, points_.compared(), there.model) -
      count * own;
  other.noise = count * noise;
  other.waits = true;
  if (Other* back = find(other.camera, camera); back != nullptr && back->waits) {
    add_to_pair(other, *back, pairs_[index_of(camera, other.camera)]);
  }
}

void CameraAssignment::add_to_pair(Other& one, Other& other, Pair& pair) const {
  const double ratio = (one.gain + other.gain) / (0.5 * (one.noise + other.noise));
  const double step = std::clamp(ratio, -most_, most_) - most_ / 2;
  pair.evidence = std::clamp(pair.evidence + step, 0.0, threshold_);
  pair.swapped = pair.evidence >= threshold_ || (pair.swapped && pair.evidence > 0);
  one.waits = other.waits = false;
}

CameraAssignment::Other* CameraAssignment::find(size_t camera, size_t place) {
  const auto found = std::ranges::find(rig_[camera].others, place, &Other::camera);
  return found == rig_[camera].others.end() ? nullptr : &*found;
}

std::string CameraAssignment::images_of(size_t camera) const {
  std::string names;
  for (const Other& other : rig_[camera].others) {
    if (!pairs_[index_of(camera, other.camera)].swapped) continue;
    if (!names.empty()) names += " or ";
    names += rig_[other.camera].name;
  }
  return names;
}

}  // namespace infuse::monitoring

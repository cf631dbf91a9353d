#pragma once

#include <string>
#include <vector>

#include "fusion/monitoring/drift_detector.hpp"
#include "fusion/monitoring/monitor_dependence.hpp"

namespace infuse::monitoring {

/// A camera of a rig, and its place.
struct PlacedCamera {
  std::string name;
  CameraIntrinsics intrinsics;
  size_t lidar = 0;  ///< which it is calibrated to
  Eigen::Isometry3d T_camera_lidar;
};

/// Tests whether the images of a rig's cameras are those of others: cables or devices that were
/// swapped. Each evaluation of a camera is compared at the place of one other camera of the same
/// lidar and image size, in turn. With D(i, j) the nats of all returns by the image of camera i at
/// the place of camera j, a CUSUM (Page 1954) for each pair adds
///   (D(i, j) + D(j, i) − D(i, i) − D(j, j)) / κ,
/// limited for each comparison and less half that limit, its reference value. What any image shows
/// at a place (ground below, houses above) counts on both sides; a single camera that was turned
/// away by far gains nothing, since the other one has its own images still. Pure; allocates nothing
/// after its first sweep of a size.
class CameraAssignment {
 public:
  /// `options.invalid()` must be empty.
  CameraAssignment(const std::vector<PlacedCamera>& rig, const DriftDetectorOptions& options,
                   const MonitorDependence::Weights& weights, size_t max_points);

  /// Moves the place of a camera: its calibration has changed.
  void set_place(size_t camera, const Eigen::Isometry3d& T_camera_lidar);

  /// Compares an image of camera `camera`. `own`: nats per return at its own place, or where a
  /// search of a drift leads if that is more, of the returns `points`; `noise`:
  /// `DriftDetector::noise`.
  void add(size_t camera, const ComparedPlanes& planes, const SweepView& sweep, double own,
           const MonitorPoints& points, double noise);

  /// Name of the camera whose images the images of `camera` are; empty: its own. "a or b" where
  /// more than two cameras are swapped in a ring.
  std::string images_of(size_t camera) const;

 private:
  /// What one camera's images gain at the place of another.
  struct Other {
    size_t camera = 0;
    double gain = 0, noise = 0;  // nats, of the last image
    bool waits = false;          // for the other camera's
  };
  /// Evidence that two cameras are swapped.
  struct Pair {
    double evidence = 0;   // nats
    bool swapped = false;  // from the threshold on, until nothing is left
  };
  struct Placed {
    std::string name;
    geometry::CameraModel model;
    Eigen::Isometry3d T_camera_lidar;
    std::vector<Other> others;
    size_t next = 0;  // of `others`, that is compared next
  };
  Other* find(size_t camera, size_t place);
  void add_to_pair(Other& one, Other& other, Pair& pair) const;

  std::vector<Placed> rig_;
  std::vector<Pair> pairs_;  // by the larger index, then the smaller
  double threshold_, most_;
  size_t max_points_;
  MonitorPoints points_;
  MonitorDependence dependence_;
};

}  // namespace infuse::monitoring

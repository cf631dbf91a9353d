#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "fusion/calibration/feature.hpp"
#include "fusion/features/discontinuity.hpp"
#include "fusion/features/image_edges.hpp"
#include "fusion/features/local_contrast.hpp"
#include "fusion/features/occlusion_buffer.hpp"
#include "fusion/features/relative_reflectivity.hpp"
#include "fusion/features/sweep_view.hpp"
#include "fusion/geometry/camera_model.hpp"

namespace infuse::monitoring {

using features::make_sweep_view;
using features::SweepView;

/// Planes of ranks 0 … 1 that are compared.
struct ComparedPlanes {
  int step = 1;          ///< pixels a sample of the reduced image that the planes were made of
  features::Plane grey;  ///< rank relative to the surroundings (`features::LocalContrast`)
  features::Plane edge;  ///< rank of the edge strength along the rings (`features::RingEdge`)
};

/// What is compared of an image.
struct ComparedImage {
  ComparedPlanes fine;    ///< some hundred samples wide, blurred a little
  ComparedPlanes coarse;  ///< blurred by `kCoarseBlur` samples and thinned: for far steps
};

/// What is compared of a sweep: returns with the bins of their features.
struct ComparedReturns {
  static constexpr int kBins = calibration::kHistogramBins;
  static constexpr uint8_t kNotCompared = 255;  ///< edge bin (8 bits) where no edge is near

  std::vector<float> x, y, z;  ///< m, in the lidar's frame
  std::vector<uint8_t> reflectivity_bin, edge_bin;

  size_t size() const { return x.size(); }
  geometry::PointsView points() const { return {x, y, z}; }
  /// Becomes at most `count` of others' returns, evenly. Allocates nothing once it has held as
  /// many.
  void thin(const ComparedReturns& others, size_t count);
};

/// Blurs planes by `sigma` samples, thins them to every `step`th and ranks them again.
class PlaneBlur {
 public:
  void compute(const ComparedPlanes& planes, double sigma, int step, ComparedPlanes& out);

 private:
  features::Blur blur_;
};

/// Reduces images to what is compared. Allocates nothing after its first image of a size.
class MonitorImage {
 public:
  /// Reduces a kGrey8 frame by means of `step` × `step` pixels. `rings`: the lidar's rings in
  /// images reduced so.
  void build(const CameraFrame& grey, int step, const features::RingDirections& rings);

  int width() const { return compared_.fine.grey.width; }
  int height() const { return compared_.fine.grey.height; }
  const ComparedImage& compared() const { return compared_; }

 private:
  ComparedImage compared_;
  features::Plane reduced_, raw_;
  features::RingEdge ring_edge_;
  features::LocalContrast local_contrast_;
  features::Blur blur_;
  PlaneBlur plane_blur_;
};

/// Returns that are compared with the image: in view, not hidden, thinned. Allocates nothing after
/// its first sweep of a size.
class MonitorPoints {
 public:
  /// Selects at most `max_points` returns that `camera` sees under `T_camera_lidar`, evenly. Lidar
  /// features are sorted into bins of equal filling.
  void select(const SweepView& sweep, const geometry::CameraModel& camera,
              const Eigen::Isometry3d& T_camera_lidar, size_t max_points);
  /// The same with the features of this sweep that `others` computed, and keeps meanwhile.
  void select(const SweepView& sweep, const MonitorPoints& others,
              const geometry::CameraModel& camera, const Eigen::Isometry3d& T_camera_lidar,
              size_t max_points);

  size_t size() const { return compared_.size(); }
  const ComparedReturns& compared() const { return compared_; }
  /// m along the optical axis under the pose of the selection.
  const std::vector<float>& depth() const { return depth_; }
  /// Indices in the sweep of the returns in the image or up to a tenth of its size outside, hidden
  /// or not: those that another calibration might bring into view.
  const std::vector<uint32_t>& near_image() const { return near_image_; }
  /// `features::Discontinuity` of every return of the sweep, √m; NaN: not compared.
  std::span<const float> discontinuity() const { return discontinuity_; }
  /// `features::RelativeReflectivity` of every return of the sweep.
  std::span<const float> reflectivity() const { return reflectivity_; }

 private:
  void select_visible(const SweepView& sweep, const geometry::CameraModel& camera,
                      const Eigen::Isometry3d& T_camera_lidar, size_t max_points);
  void find_visible(const SweepView& sweep, const geometry::CameraModel& camera,
                    const Eigen::Isometry3d& T_camera_lidar);
  void sort_into_bins(std::span<const float> feature, std::vector<uint8_t>& bins);

  ComparedReturns compared_;
  std::vector<float> depth_;
  std::vector<uint32_t> visible_, near_image_;
  features::Discontinuity discontinuities_;
  features::RelativeReflectivity relative_reflectivity_;
  features::OcclusionBuffer occlusion_{{}};
  std::span<const float> discontinuity_, reflectivity_;
  // Scratch.
  std::vector<float> u_, v_, all_depth_, values_;
};

}  // namespace infuse::monitoring

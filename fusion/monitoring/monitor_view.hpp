#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
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

/// Image reduced to what the monitor compares: two planes of ranks 0 … 1, some hundred samples
/// wide, blurred a little. Allocates nothing after its first image of a size.
class MonitorImage {
 public:
  /// Reduces a kGrey8 frame by means of `step` × `step` pixels. `rings`: the lidar's rings in
  /// images reduced so.
  void build(const CameraFrame& grey, int step, const features::RingDirections& rings);

  int width() const { return grey_.width; }
  int height() const { return grey_.height; }
  int step() const { return step_; }
  /// The same planes, blurred by `kCoarseBlur` samples and thinned: for steps beyond the peak.
  const features::Plane& coarse_grey() const { return coarse_grey_; }
  const features::Plane& coarse_edge() const { return coarse_edge_; }
  const features::Plane& fine_grey() const { return grey_; }
  const features::Plane& fine_edge() const { return edge_; }
  /// Rank of grey relative to its surroundings (`features::LocalContrast`), rows from the top.
  const std::vector<float>& grey() const { return grey_.values; }
  /// Rank of the edge strength along the lidar's rings (`features::RingEdge`).
  const std::vector<float>& edge() const { return edge_.values; }

 private:
  int step_ = 1;
  features::Plane reduced_, raw_, grey_, edge_, coarse_grey_, coarse_edge_;
  features::RingEdge ring_edge_;
  features::LocalContrast local_contrast_;
  features::Blur blur_;
};

/// Returns that are compared with the image: in view, not hidden, thinned. Allocates nothing after
/// its first sweep of a size.
class MonitorPoints {
 public:
  /// Selects at most `max_points` returns that `camera` sees under `T_camera_lidar`, evenly. Lidar
  /// features are sorted into `kBins` bins of equal filling.
  void select(const SweepView& sweep, const geometry::CameraModel& camera,
              const Eigen::Isometry3d& T_camera_lidar, size_t max_points);

  static constexpr int kBins = 16;
  static constexpr uint8_t kNotCompared = 255;  ///< edge bin of a return without an edge near it
  size_t size() const { return x_.size(); }
  geometry::PointsView points() const { return {x_, y_, z_}; }
  /// m along the optical axis under the pose of the selection.
  const std::vector<float>& depth() const { return depth_; }
  const std::vector<uint8_t>& reflectivity_bin() const { return reflectivity_bin_; }
  const std::vector<uint8_t>& edge_bin() const { return edge_bin_; }
  /// Indices in the sweep of the returns in the image or up to a tenth of its size outside, hidden
  /// or not: those that another calibration might bring into view.
  const std::vector<uint32_t>& near_image() const { return near_image_; }
  /// `features::Discontinuity` of every return of the sweep, √m; NaN: not compared.
  std::span<const float> discontinuity() const { return discontinuity_; }
  /// `features::RelativeReflectivity` of every return of the sweep.
  std::span<const float> reflectivity() const { return reflectivity_; }

 private:
  void find_visible(const SweepView& sweep, const geometry::CameraModel& camera,
                    const Eigen::Isometry3d& T_camera_lidar);
  void sort_into_bins(std::span<const float> feature, std::vector<uint8_t>& bins);

  std::vector<float> x_, y_, z_, depth_;
  std::vector<uint8_t> reflectivity_bin_, edge_bin_;
  std::vector<uint32_t> visible_, near_image_;
  features::Discontinuity discontinuities_;
  features::RelativeReflectivity relative_reflectivity_;
  features::OcclusionBuffer occlusion_{{}};
  std::span<const float> discontinuity_, reflectivity_;
  // Scratch.
  std::vector<float> u_, v_, all_depth_, values_;
};

}  // namespace infuse::monitoring

#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/calibration/relative_reflectivity.hpp"
#include "fusion/geometry/camera_model.hpp"
#include "fusion/geometry/project_points.hpp"

namespace infuse::monitoring {

/// A sweep made straight, as spans: points in the lidar frame at the picture's exposure, and the
/// quantities that stay in the sweep, index for index.
struct SweepView {
  geometry::PointsView points;             ///< m
  std::span<const float> range;            ///< m
  std::span<const float> reflectivity;     ///< 0 … 1
  std::span<const uint16_t> ring, column;  ///< as Sweep's

  size_t size() const { return range.size(); }
};

/// The view of a sweep that needed no straightening.
SweepView make_sweep_view(const Sweep& sweep);

/// A picture reduced to what the watch compares: two planes of ranks 0 … 1, some hundred samples
/// wide, blurred a little. Grey is ranked by how it stands against its surroundings, as
/// `calibration::normalize_local_contrast` tells why. Keeps its memory.
class MonitorImage {
 public:
  /// Reduces a kGrey8 frame by block means of `step` pixels; `step` divides what is used of it.
  void build(const CameraFrame& grey, int step);

  int width() const { return width_; }
  int height() const { return height_; }
  int step() const { return step_; }
  /// Rank of the local grey level, and of edge strength (I 4.3.1.4), rows from the top.
  const std::vector<float>& grey() const { return grey_; }
  const std::vector<float>& edge() const { return edge_; }

 private:
  void reduce(const CameraFrame& frame);
  void find_edges();
  void normalize_local_contrast();
  void rank(std::vector<float>& plane);
  void smooth(std::vector<float>& plane);

  int width_ = 0, height_ = 0, step_ = 1;
  std::vector<float> grey_, edge_, scratch_;
  std::vector<uint32_t> sums_;
  std::vector<double> integral_;  ///< sums of grey and of its square over what lies above and left
};

/// The returns that take part: in view, not hidden, thinned. Keeps its memory.
class MonitorPoints {
 public:
  /// Picks at most `most` returns that `camera` sees under `T_camera_lidar`, evenly. Lidar features
  /// are sorted into `kBins` bins of equal filling.
  void select(const SweepView& sweep, const geometry::CameraModel& camera,
              const Eigen::Isometry3d& T_camera_lidar, size_t max_points);

  static constexpr int kBins = 16;
  static constexpr uint8_t kNotCompared = 255;  ///< edge bin of a return with no edge beside it
  size_t size() const { return x_.size(); }
  geometry::PointsView points() const { return {x_, y_, z_}; }
  /// m along the optical axis under the pose that they were picked with.
  const std::vector<float>& depth() const { return depth_; }
  const std::vector<uint8_t>& reflectivity_bin() const { return reflectivity_bin_; }
  const std::vector<uint8_t>& edge_bin() const { return edge_bin_; }
  /// Indices in the sweep of what lies in the picture or up to a tenth of its size outside, hidden
  /// or not: what another calibration might bring into view.
  const std::vector<uint32_t>& near_image() const { return near_image_; }
  /// Scan discontinuity I(3.6) of every return of the sweep, √m; NaN where none is beside it.
  const std::vector<float>& discontinuity() const { return discontinuity_; }
  /// `calibration::RelativeReflectivity` of every return of the sweep.
  std::span<const float> reflectivity() const { return relative_; }

 private:
  void find_discontinuity(const SweepView& sweep);
  void mask_far_from_edges(const SweepView& sweep);
  void find_visible(const SweepView& sweep, const geometry::CameraModel& camera,
                    const Eigen::Isometry3d& T_camera_lidar);
  void sort_into_bins(const std::vector<float>& values, std::vector<uint8_t>& bins);

  std::vector<float> x_, y_, z_, depth_;
  std::vector<uint8_t> reflectivity_bin_, edge_bin_;
  std::vector<uint32_t> visible_, near_image_;
  // Scratch.
  std::vector<float> u_, v_, all_depth_, nearest_, values_, discontinuity_;
  std::vector<uint32_t> last_of_ring_;
  std::vector<uint8_t> near_edge_;
  calibration::RelativeReflectivity ranks_;
  std::span<const float> relative_;
};

}  // namespace infuse::monitoring

#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/pipeline/image_match.hpp"
#include "daemon/pipeline/latest_value.hpp"
#include "daemon/setup/sensor_id.hpp"
#include "drivers/measurement/camera_frame.hpp"
#include "fusion/features/sweep_view.hpp"

namespace infuse::daemon {

/// Returns of a sweep, quantised, in the lidar frame; at most `ViewTap::kMaxPoints` of them.
struct ViewPoints {
  std::vector<int16_t> x, y, z;       ///< cm
  std::vector<uint8_t> reflectivity;  ///< 0 … 255
  std::vector<uint8_t> ring;          ///< the last 255 and above are alike

  size_t size() const { return x.size(); }
};

/// Where the vehicle is on the street map.
struct ViewMapPose {
  static constexpr size_t kMaxParticles = 300;
  Eigen::Isometry3d T_map_vehicle = Eigen::Isometry3d::Identity();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< m², of x and y, map frame
  std::vector<Eigen::Vector2f> particles;  ///< m, map frame; at most kMaxParticles, none when sure
};

/// A sweep to look at.
struct ViewSweep {
  Stamp stamp;  ///< of the points
  LidarIndex lidar;
  bool deskewed = false;
  std::optional<Eigen::Isometry3d> T_odom_vehicle;  ///< nothing without odometry
  std::optional<ViewMapPose> map;                   ///< nothing without a place on a street map
  ViewPoints points;
};

/// All returns of a sweep as they were measured, deskewed: what a dependence profile needs.
struct ViewReturns {
  FieldVector<float> x, y, z;              ///< m, lidar frame
  FieldVector<float> range, reflectivity;  ///< as in `Sweep`, as the next two
  FieldVector<uint16_t> ring, column;

  bool empty() const { return range.empty(); }
  features::SweepView view() const { return {{x, y, z}, range, reflectivity, ring, column}; }
};

/// An image to look at, and the returns as of its exposure.
struct ViewImage {
  CameraIndex camera;
  CameraFrame frame;
  Eigen::Isometry3d T_camera_lidar = Eigen::Isometry3d::Identity();  ///< in use
  std::optional<Eigen::Isometry3d> T_camera_lidar_estimate;          ///< of the last re-estimation
  ViewPoints points;
  ViewReturns returns;  ///< empty unless they were asked for
};

/// The latest sweep and images, from the fusion thread to somebody who looks. Nothing is copied
/// while nobody does, and the fusion thread never waits.
class ViewTap {
 public:
  static constexpr size_t kMaxPoints = 40'000;

  explicit ViewTap(size_t cameras);

  /// Somebody looks; from any thread.
  void set_wanted(bool wanted) { wanted_.store(wanted, std::memory_order_relaxed); }
  bool wanted() const { return wanted_.load(std::memory_order_relaxed); }

  /// Adds what the fusion thread has made, if it is wanted.
  void add_sweep(const SweepSnapshot& snapshot, const Eigen::Isometry3d* T_odom_vehicle,
                 const ViewMapPose* map = nullptr);
  /// `estimate`: of the last re-estimation; null: none yet.
  void add_image(const ImageMatch& match, const Eigen::Isometry3d* estimate = nullptr);

  /// Swaps the latest one into `out`; false if there is none that is new. `with_returns`: the next
  /// images of the camera bring all their returns.
  bool swap_sweep(ViewSweep& out);
  bool swap_image(CameraIndex camera, ViewImage& out, bool with_returns = false);

  size_t cameras() const { return images_.size(); }

 private:
  struct Images {
    LatestValue<ViewImage> latest;
    std::atomic<bool> with_returns = false;
  };

  std::atomic<bool> wanted_ = false;
  LatestValue<ViewSweep> sweep_;
  std::vector<Images> images_;  // by CameraIndex
};

/// Quantises the returns of a sweep: every n-th, so that at most `max_points` remain.
void quantise(const SweepSnapshot& snapshot, size_t max_points, ViewPoints& points);

}  // namespace infuse::daemon

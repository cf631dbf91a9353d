#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/features/discontinuity.hpp"
#include "fusion/features/occlusion_buffer.hpp"
#include "fusion/geometry/camera_model.hpp"
#include "fusion/streetmap/image_features.hpp"
#include "fusion/streetmap/planar_pose.hpp"

namespace infuse::streetmap {

/// What a cell of the local grid knows, I table 3.4 and reflectivity.
enum Feature : int {
  kHeight = 0,         ///< m above the vehicle's ground, compressed: sign(h)·√|h|
  kDiscontinuity = 1,  ///< √m, I(3.6)
  kReflectivity = 2,   ///< 0 … 1
  kBlue = 3,           ///< 0 … 1
  kGreen = 4,
  kRed = 5,
  kGradient = 6,  ///< Sobel magnitude, square root
};
inline constexpr int kFeatureCount = 7;
inline constexpr int kLidarFeatureCount = 3;  ///< the first ones need no camera

/// How the grid collects.
struct LocalGridOptions {
  double extent = 40;        ///< m, edge of the square around the vehicle that is kept
  double cell_size = 0.1;    ///< m
  int block_size = 4;        ///< cells along the edge of a block that becomes one sample
  double min_height = -1.0;  ///< m above ground: returns below are left out
  double max_height = 3.0;   ///< m above ground: returns above (crowns of trees) are left out
  double min_range = 1.5;    ///< m from the lidar: nearer returns are the vehicle's own
  int mean_window = 24;      ///< returns that a cell's mean stands for: things that move fade out
  int max_samples = 1500;    ///< blocks that are given out, chosen at random
  uint64_t seed = 1;         ///< of that choice

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// A sweep made straight: index for index the returns of `sweep` at one moment.
struct DeskewedView {
  const Sweep& sweep;              ///< ring, column, range, reflectivity
  std::span<const float> x, y, z;  ///< m, lidar frame at that moment
  Eigen::Isometry3d T_vehicle_lidar = Eigen::Isometry3d::Identity();
};

/// A picture that sees the same.
struct ImageView {
  const ImageFeatures& features;
  const geometry::CameraModel& camera;
  Eigen::Isometry3d T_camera_lidar =
      Eigen::Isometry3d::Identity();  ///< from the lidar at the sweep's moment to the camera at the
                                      ///< picture's
};

/// Numbers by sample and feature, samples next to each other; unlike Eigen's matrices it keeps its
/// memory when it becomes smaller.
class FeatureTable {
 public:
  void resize(Eigen::Index rows, Eigen::Index columns) {
    values_.resize(static_cast<size_t>(rows * columns));
    rows_ = rows;
    columns_ = columns;
  }
  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return columns_; }
  double* data() { return values_.data(); }
  const double* data() const { return values_.data(); }
  double& operator()(Eigen::Index row, Eigen::Index column) {
    return values_[static_cast<size_t>(column * rows_ + row)];
  }
  double operator()(Eigen::Index row, Eigen::Index column) const {
    return values_[static_cast<size_t>(column * rows_ + row)];
  }

  /// As Eigen sees it, while it lives and is not resized.
  Eigen::Map<const Eigen::MatrixXd> matrix() const { return {values_.data(), rows_, columns_}; }

  bool operator==(const FeatureTable&) const = default;

 private:
  std::vector<double> values_;
  Eigen::Index rows_ = 0, columns_ = 0;
};

/// The local grid as samples: one a block of cells that returns fell into.
struct GridSamples {
  std::vector<float> x, y;  ///< m, vehicle frame
  FeatureTable features;    ///< n × kFeatures, or × kLidarFeatures where no cell has a colour;
                            ///< each column of mean 0 and variance 1, clipped at ±3

  size_t size() const { return x.size(); }
};

/// The ground around the vehicle, I 3.4.3.1: a grid in the frame of the odometry, into which
/// straight sweeps, coloured by pictures, are collected while the vehicle moves. Cells are
/// overwritten when the vehicle has moved on by the grid's extent; each holds means that forget, so
/// that what moved away fades.
class LocalGrid {
 public:
  /// `options.invalid()` must be empty. All memory is taken here.
  explicit LocalGrid(const LocalGridOptions& options = {});

  /// Adds a sweep taken at `pose` (odometry frame), with a picture or null.
  void add(const DeskewedView& deskewed, const ImageView* image, const PlanarPose& pose);

  /// The grid as seen from `pose`. Allocates nothing once `samples` has been as large.
  void draw_samples(const PlanarPose& pose, GridSamples& samples);

  /// Forgets everything.
  void clear();

 private:
  struct Cell {
    int32_t column = INT32_MIN, row = INT32_MIN;  // of the odometry frame, to tell old from new
    float lidar_count = 0, colour_count = 0;
    std::array<float, kFeatureCount> mean{};
  };
  struct Block {
    float x, y;
    std::array<float, kFeatureCount> mean;
    bool coloured;
  };

  Cell& cell_at(int32_t column, int32_t row);
  void project(const DeskewedView& deskewed, const ImageView& image);
  bool visible(size_t i) const;
  void gather_blocks(const PlanarPose& pose);
  void standardise(GridSamples& samples) const;

  LocalGridOptions options_;
  int cells_per_edge_;  // along an edge
  std::vector<Cell> grid_;
  uint64_t draws_ = 0;

  // Scratch.
  std::vector<float> u_, v_, depth_;
  features::Discontinuity discontinuities_;
  features::OcclusionBuffer occlusion_;
  std::vector<Block> blocks_;
};

}  // namespace infuse::streetmap

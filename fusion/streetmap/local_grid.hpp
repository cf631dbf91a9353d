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

/// Features of a grid cell: I table 3.4, and reflectivity.
enum Feature : int {
  kHeight = 0,         ///< m above the vehicle's ground, compressed: sign(h)·√|h|
  kDiscontinuity = 1,  ///< √m, I(3.6)
  kReflectivity = 2,   ///< 0 … 1
  kBlue = 3,           ///< 0 … 1
  kGreen = 4,
  kRed = 5,
  kGradient = 6,  ///< Sobel magnitude, square root
};
inline constexpr int kFeatureCount = kGradient + 1;
inline constexpr int kLidarFeatureCount = kReflectivity + 1;  ///< leading ones, without a camera

/// Settings of `LocalGrid`.
struct LocalGridOptions {
  double extent = 40;        ///< m, edge of the square around the vehicle
  double cell_size = 0.1;    ///< m, I 3.4.3.1
  int block_size = 4;        ///< edge in cells of a block, which is one sample, I 3.4.3.1
  double min_height = -1.0;  ///< m above ground; lower returns are dropped
  double max_height = 3.0;   ///< m above ground; higher returns (tree crowns) are dropped
  double min_range = 1.5;    ///< m from the lidar; nearer returns hit the vehicle itself
  int mean_window =
      24;  ///< returns over which the mean of a cell extends, so that moving objects fade
  int max_samples = 1500;  ///< maximum number of samples, chosen at random
  uint64_t seed = 1;       ///< seed of that choice

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// A deskewed sweep: element i is return i of `sweep`, moved to one common moment.
struct DeskewedView {
  const Sweep& sweep;              ///< ring, column, range, reflectivity
  std::span<const float> x, y, z;  ///< m, lidar frame at that moment
  Eigen::Isometry3d T_vehicle_lidar = Eigen::Isometry3d::Identity();
};

/// An image of the same scene.
struct ImageView {
  const ImageFeatures& features;
  const geometry::CameraModel& camera;
  Eigen::Isometry3d T_camera_lidar =
      Eigen::Isometry3d::Identity();  ///< from the lidar at the common moment of the sweep to the
                                      ///< camera at the exposure
};

/// Matrix of samples by features, column-major. Unlike an Eigen matrix it keeps its memory when it
/// shrinks.
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

  /// Eigen view; valid until the table is resized or destroyed.
  Eigen::Map<const Eigen::MatrixXd> matrix() const { return {values_.data(), rows_, columns_}; }

  bool operator==(const FeatureTable&) const = default;

 private:
  std::vector<double> values_;
  Eigen::Index rows_ = 0, columns_ = 0;
};

/// Samples of the local grid: one per block of cells with returns.
struct GridSamples {
  std::vector<float> x, y;  ///< m, vehicle frame
  FeatureTable features;  ///< n × kFeatureCount, or n × kLidarFeatureCount if no cell has a colour;
                          ///< each column has mean 0 and variance 1 and is clipped at ±3

  size_t size() const { return x.size(); }
};

/// Local map of the ground around the vehicle, I 3.4.3.1: a grid in the odometry frame that
/// collects deskewed sweeps, coloured by images. Cells are overwritten once the vehicle has moved
/// on by the extent of the grid. Each cell holds running means, so that moving objects fade.
class LocalGrid {
 public:
  /// Allocates all memory. `options.invalid()` must be empty.
  explicit LocalGrid(const LocalGridOptions& options = {});

  /// Adds a sweep taken at `pose` (odometry frame), with an image or null.
  void add(const DeskewedView& deskewed, const ImageView* image, const PlanarPose& pose);

  /// Draws samples of the grid as seen from `pose`. Does not allocate once `samples` has had this
  /// size.
  void draw_samples(const PlanarPose& pose, GridSamples& samples);

  /// Clears all cells.
  void clear();

 private:
  struct Cell {
    int32_t column = INT32_MIN,
            row = INT32_MIN;  // in the odometry frame, to detect outdated cells
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
  int cells_per_edge_;
  std::vector<Cell> grid_;
  uint64_t draws_ = 0;

  // Scratch.
  std::vector<float> u_, v_, depth_;
  features::Discontinuity discontinuities_;
  features::OcclusionBuffer occlusion_;
  std::vector<Block> blocks_;
};

}  // namespace infuse::streetmap

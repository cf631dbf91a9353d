#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace infuse::features {

/// Rule by which a point in view is hidden behind another one: lidar and camera do not look from
/// the same place. A point is hidden if depth > nearest · ratio + step, nearest the smallest depth
/// in its cell of the image (and around it).
struct OcclusionOptions {
  double cell_size = 5;         ///< px, side of a cell
  double ratio = 1.1;           ///< at least 1
  double step = 0.3;            ///< m
  bool with_neighbours = true;  ///< nearest of the cell and the eight around it; false: of the cell

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Smallest depth by cell of an image (z-buffer). Allocates nothing after its first image of a
/// size.
class OcclusionBuffer {
 public:
  explicit OcclusionBuffer(const OcclusionOptions& options);

  /// Empties the buffer, for images of this size, px.
  void reset(int width, int height);

  /// Adds a point; px, m along the optical axis. Points outside of the image go to its border.
  void add(float u, float v, float depth) {
    float& nearest = nearest_[cell(u, v)];
    nearest = depth < nearest ? depth : nearest;
  }

  /// True if the point is hidden behind those that were added.
  bool hides(float u, float v, float depth) const { return depth > nearest(u, v) * ratio_ + step_; }

  /// Empties the cell of a point: cheaper than `reset` where points are few.
  void clear_cell(float u, float v) { nearest_[cell(u, v)] = kEmpty; }

 private:
  static constexpr float kEmpty = std::numeric_limits<float>::infinity();

  size_t cell(float u, float v) const {
    return static_cast<size_t>(clamped(v, rows_)) * static_cast<size_t>(columns_) +
           static_cast<size_t>(clamped(u, columns_));
  }
  /// Index along an axis of so many cells, the first and the last of which are the border.
  int clamped(float at, int cells) const {
    const int index = static_cast<int>(at * cells_per_pixel_) + 1;
    return index < 1 ? 1 : index > cells - 2 ? cells - 2 : index;
  }
  float nearest(float u, float v) const;

  float cells_per_pixel_, ratio_, step_;
  bool with_neighbours_;
  int columns_ = 0, rows_ = 0;  ///< with a border of one cell around the image
  std::vector<float> nearest_;
};

}  // namespace infuse::features

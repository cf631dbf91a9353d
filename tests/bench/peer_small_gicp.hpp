#pragma once

#include <memory>

#include "fusion/registration/point_cloud.hpp"

namespace infuse::bench {

/// small_gicp on one thread, behind an interface without its types: it is compiled for this
/// processor, in a library of its own.
class [[gnu::visibility("default")]] PeerSmallGicp {
 public:
  PeerSmallGicp();
  ~PeerSmallGicp();

  /// Sets the points of the target (0) or the source (1).
  void set_points(int which, const geometry::PointsView& points);
  /// Downsamples, builds the tree and estimates the covariances from `neighbours` points. Returns
  /// the number of points left.
  size_t prepare(int which, double voxel_size, int neighbours);
  /// Aligns the prepared clouds; poses are 4 × 4 matrices by column. Returns the iterations.
  size_t align(const double* T_target_source_guess, double max_distance, double* T_target_source);

 private:
  struct Clouds;
  std::unique_ptr<Clouds> clouds_;
};

}  // namespace infuse::bench

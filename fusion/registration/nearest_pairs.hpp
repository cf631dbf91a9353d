#pragma once

#include <cstdint>
#include <vector>

#include "fusion/registration/pairs.hpp"
#include "fusion/registration/prepared_cloud.hpp"

namespace infuse::registration {

/// Pairs of the source's points with their nearest neighbours in the target, pose by pose. A
/// neighbour is sought again only where another one can have become nearer. Does not allocate once
/// it has seen a source of that size.
class NearestPairs {
 public:
  /// Begins a registration of that source.
  void begin(const PointCloud& source);

  /// Moves the source to a pose and pairs it: points without a neighbour within `max_distance` (m)
  /// have weight 0. `last_move` (m) is about what the points moved by in the last step. Returns the
  /// number of pairs.
  size_t match(const PreparedCloud& target, const PointCloud& source,
               const Eigen::Isometry3d& T_target_source, double max_distance, double last_move);

  const Pairs& pairs() const { return pairs_; }

 private:
  void search(const PreparedCloud& target, size_t begin, float max_distance, float margin);

  Pairs pairs_;
  // Where each point was when its nearest neighbour was last sought, and how far it may move until
  // another one can be nearer.
  Pairs::Field searched_x_, searched_y_, searched_z_, slack_;
  std::vector<int32_t> index_;
};

}  // namespace infuse::registration

#pragma once

#include <list>
#include <memory>

#include "daemon/mapping/map_folder.hpp"
#include "fusion/mapping/moving_points.hpp"

namespace infuse::daemon {

/// Clouds of a map without what moved while they were measured: each is judged by the views of the
/// keyframes around it. Keeps the clouds that were read last, a bounded number of them.
class StaticClouds {
 public:
  /// `folder` and `map` must outlive this object.
  StaticClouds(const MapFolder& folder, const MapContent& map);

  /// The cloud of keyframe k without moving points. Fails if a cloud is damaged.
  Result<mapping::Submap> read(size_t k);

  size_t points() const { return points_; }    ///< number of points read so far
  size_t removed() const { return removed_; }  ///< number of those that were left out

 private:
  struct Kept {
    size_t keyframe;
    std::unique_ptr<mapping::SubmapView> view;
  };
  Result<const mapping::SubmapView*> view_of(size_t k);

  const MapFolder& folder_;
  const MapContent& map_;
  std::list<Kept> kept_;  ///< the one used last comes first
  size_t points_ = 0, removed_ = 0;
};

}  // namespace infuse::daemon

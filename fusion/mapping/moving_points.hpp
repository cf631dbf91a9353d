#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fusion/features/neighbour_search.hpp"
#include "fusion/mapping/submap.hpp"
#include "fusion/registration/range_image.hpp"
#include "fusion/registration/view_agreement.hpp"

namespace infuse::mapping {

/// Settings of the search for points of moving objects.
struct MovingPointsOptions {
  double max_range = 40;  ///< m from a view; farther its beams lie too far apart to judge
  double min_clearance = registration::kClearance;  ///< m, by which a beam goes on behind a place
  double support = 0.3;        ///< m, distance of a point of a view that confirms another
  size_t min_refutations = 2;  ///< number of views whose beams passed through
  double min_ratio = 2;        ///< of refutations to confirmations

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// A submap that judges the points of others. Does not move: it refers to the submap's points.
struct SubmapView {
  explicit SubmapView(Submap content);
  SubmapView(const SubmapView&) = delete;
  SubmapView& operator=(const SubmapView&) = delete;

  Submap submap;
  registration::RangeImage ranges;
  features::NeighbourSearch search;
};

/// Another view and where it is.
struct PlacedView {
  const SubmapView* view;
  Eigen::Isometry3d T_view_submap;
};

/// Whether each point of a submap is of something that moved: the beams of other views passed
/// through its place, and few of them have a point there. What moves as fast as the vehicle leaves
/// a point in every view, but elsewhere in each. `options.invalid()` must be empty.
std::vector<bool> find_moving_points(const Submap& submap, std::span<const PlacedView> views,
                                     const MovingPointsOptions& options = {});

/// The points of a submap that do not move, in their order.
Submap without_moving_points(const Submap& submap, const std::vector<bool>& moving);

}  // namespace infuse::mapping

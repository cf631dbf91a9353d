#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "fusion/streetmap/street_plan.hpp"

namespace infuse::streetmap {

/// How a plan becomes a raster.
struct RasterOptions {
  double cell_size = 0.2;   ///< m
  double margin = 20;       ///< m of open land around all elements
  double max_extent = 1e5;  ///< m along an edge; larger maps are refused
  double max_area = 2.5e8;  ///< m² that the raster may cover

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// Gives each strip and area, each kerb and wall an id of its own, I 3.4.1 from vector data, and
/// draws them: areas (large ones first), buildings, pavements, footways, kerbs, carriageways,
/// crossings, each over what came before; walls last where no carriageway passes. Where
/// carriageways meet there is no kerb. The result is the file that `SegmentMap::open` reads. Fails
/// where the plan is empty or too large.
Result<std::vector<std::byte>> rasterise(const StreetPlan& plan, const RasterOptions& options,
                                         std::string_view provenance);

}  // namespace infuse::streetmap

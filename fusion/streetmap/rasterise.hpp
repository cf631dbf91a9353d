#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "fusion/streetmap/segment_map.hpp"
#include "fusion/streetmap/street_plan.hpp"

namespace infuse::streetmap {

/// Settings of `rasterise`.
struct RasterOptions {
  double cell_size = MapFrame{}.cell_size;  ///< m
  double margin = 20;                       ///< m of open land around all elements
  double corridor = 100;    ///< m around streets and footways that are drawn; without any of them
                            ///< all elements are drawn
  double max_extent = 1e5;  ///< m, maximum edge length: bounds memory
  double max_area = 5e8;    ///< m², maximum area that is drawn: bounds memory

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// Gives each strip, area, kerb and wall an id, I 3.4.1 from vector data, and draws them in this
/// order, each over the ones before: areas (large ones first), buildings, pavements, footways,
/// kerbs, carriageways, crossings; walls last except on carriageways. There is no kerb where
/// carriageways of one layer meet; a higher layer is drawn with its kerbs over a lower one. Returns
/// the file that `SegmentMap::open` reads. Fails, before it draws, if the plan is empty or too
/// large. `progress` is called with the share that is drawn.
Result<std::vector<std::byte>> rasterise(const StreetPlan& plan, const RasterOptions& options,
                                         std::string_view provenance,
                                         const std::function<void(double)>& progress = {});

}  // namespace infuse::streetmap

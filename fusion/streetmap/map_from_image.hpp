#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"
#include "fusion/streetmap/segment_map.hpp"

namespace infuse::streetmap {

/// Settings of `make_map_from_image`.
struct ImageMapOptions {
  double metres_per_pixel = MapFrame{}.cell_size;  ///< edge of a pixel on the ground
  double edge_threshold = 60;  ///< minimum Sobel magnitude (grey values, 0 … 1442) of a line
  int min_region_pixels = 25;  ///< pixels; smaller closed regions become part of the lines

  /// Returns what is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// Makes a map from an image of one (a screenshot of a street map, north up), I 3.4.1: a Sobel
/// filter finds boundary lines, then a flood fill gives every closed region and every connected
/// line an id. The origin is the middle of the image; there is no latitude and longitude. `grey` is
/// kGrey8. Returns the file that `SegmentMap::open` reads. Fails if the image is too small, is not
/// grey or has no closed regions.
Result<std::vector<std::byte>> make_map_from_image(const CameraFrame& grey,
                                                   const ImageMapOptions& options,
                                                   std::string_view provenance);

}  // namespace infuse::streetmap

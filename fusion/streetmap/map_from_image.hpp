#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::streetmap {

/// How a picture of a map becomes segments.
struct ImageMapOptions {
  double metres_per_pixel = 0.2;  ///< edge of a pixel on the ground
  double edge_threshold = 60;     ///< Sobel magnitude (grey values, 0 … 1442) that makes a line
  int min_region_pixels = 25;     ///< pixels; smaller closed regions become part of the lines

  /// What is wrong, or nothing.
  std::optional<std::string> invalid() const;
};

/// The map of a picture (a screenshot of a street map, north up), I 3.4.1: boundary lines by the
/// Sobel filter, then every closed region and every connected line gets an id by flood fill. The
/// origin is the picture's middle; there is no latitude and longitude. `grey` is kGrey8. The result
/// is the file that `SegmentMap::open` reads.
Result<std::vector<std::byte>> make_map_from_image(const CameraFrame& grey,
                                                   const ImageMapOptions& options,
                                                   std::string_view provenance);

}  // namespace infuse::streetmap

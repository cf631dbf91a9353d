#pragma once

#include <optional>
#include <string>

#include "daemon/mapping/map_image.hpp"
#include "daemon/mapping/map_projection.hpp"

namespace infuse::daemon {

/// Formats a raster as GeoTIFF 1.0: one band of 32-bit floating-point numbers,
/// deflated in strips, with the side of a pixel and the coordinates of the north-western corner.
/// Pixels without points are NaN, which the file states as its nodata value (as GDAL does). With a
/// projection the file names its coordinate system (EPSG 326xx, 327xx), in which the raster must
/// be; without one the coordinates are those of the map's frame. Fails where the raster is empty.
Result<std::string> format_geotiff(const MapRaster& raster,
                                   const std::optional<MapProjection>& projection);

}  // namespace infuse::daemon

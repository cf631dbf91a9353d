#pragma once

#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "daemon/mapping/map_projection.hpp"
#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/error.hpp"
#include "fusion/mapping/submap.hpp"

namespace infuse::daemon {

/// What an image of a map shows.
enum class MapImageContent { kIntensity, kHeight };

/// Values of a view from above, row by row from the north; NaN where there are no points.
struct MapRaster {
  int64_t width = 0, height = 0;
  double pixel = 0;          ///< m, side
  double left = 0, top = 0;  ///< m, outer corner of the first pixel
  std::vector<float> values;
};

/// A drawn raster: grey values from 1 for `low` to 255 for `high`, the 2nd and 98th percentile of
/// its values; 0 without points.
struct MapDrawing {
  CameraFrame image;
  float low = 0, high = 0;
};

/// View of a map from above, x to the right and y up (in a georeferenced map east and north): mean
/// reflectivity, or height of the highest point, of each pixel.
class MapImage {
 public:
  /// Side of a pixel, m.
  explicit MapImage(double pixel) : pixel_(pixel) {}

  /// Adds the points of a cloud; `projection`, if given, takes them from the frame of the map to
  /// that of the image.
  void add(const mapping::Submap& cloud, const Eigen::Isometry3d& T_map_cloud,
           const MapProjection* projection = nullptr);

  /// Fails if there are no points or the image would have more than 64 million pixels.
  Result<MapRaster> raster(MapImageContent content) const;

  /// Draws the raster.
  Result<MapDrawing> draw(MapImageContent content) const;

 private:
  struct Pixel {
    float reflectivity = 0, count = 0, height = 0;
  };
  double pixel_;
  std::unordered_map<uint64_t, Pixel> pixels_;  // by column and row
};

}  // namespace infuse::daemon

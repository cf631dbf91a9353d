#include "daemon/mapping/map_image.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "drivers/measurement/median.hpp"

namespace infuse::daemon {
namespace {

constexpr int64_t kMaxPixels = 64'000'000;
constexpr double kMaxPixelIndex = 1e9;

uint64_t pixel_key(int32_t column, int32_t row) {
  return static_cast<uint64_t>(static_cast<uint32_t>(column)) << 32 | static_cast<uint32_t>(row);
}
int32_t column_of(uint64_t key) { return static_cast<int32_t>(static_cast<uint32_t>(key >> 32)); }
int32_t row_of(uint64_t key) { return static_cast<int32_t>(static_cast<uint32_t>(key)); }

float percentile(std::vector<float> values, double share) {
  return nth_smallest(values, static_cast<size_t>(share * static_cast<double>(values.size() - 1)));
}

}  // namespace

void MapImage::add(const mapping::Submap& cloud, const Eigen::Isometry3d& T_map_cloud,
                   const MapProjection* projection) {
  for (size_t i = 0; i < cloud.size(); ++i) {
    Eigen::Vector3d p = T_map_cloud * Eigen::Vector3d(cloud.x[i], cloud.y[i], cloud.z[i]);
    if (projection != nullptr) p = projection->project(p);
    const double column = std::floor(p.x() / pixel_), row = std::floor(p.y() / pixel_);
    if (!(std::abs(column) < kMaxPixelIndex && std::abs(row) < kMaxPixelIndex)) continue;
    const auto key = pixel_key(static_cast<int32_t>(column), static_cast<int32_t>(row));
    Pixel& pixel = pixels_[key];
    const auto height = static_cast<float>(p.z());
    pixel.height = pixel.count > 0 ? std::max(pixel.height, height) : height;
    pixel.reflectivity += cloud.reflectivity[i];
    ++pixel.count;
  }
}

Result<MapRaster> MapImage::raster(MapImageContent content) const {
  if (pixels_.empty()) return fail("the map has no points");
  int32_t left = std::numeric_limits<int32_t>::max(), right = std::numeric_limits<int32_t>::min();
  int32_t bottom = left, top = right;
  for (const auto& [key, pixel] : pixels_) {
    left = std::min(left, column_of(key));
    right = std::max(right, column_of(key));
    bottom = std::min(bottom, row_of(key));
    top = std::max(top, row_of(key));
  }
  MapRaster out;
  out.width = int64_t{right} - left + 1;
  out.height = int64_t{top} - bottom + 1;
  if (out.width > kMaxPixels / out.height) {
    return fail("the image would be too large", "", "raise --voxel");
  }
  out.pixel = pixel_;
  out.left = pixel_ * left;
  out.top = pixel_ * (double{1} + top);
  out.values.assign(static_cast<size_t>(out.width * out.height),
                    std::numeric_limits<float>::quiet_NaN());
  for (const auto& [key, pixel] : pixels_) {
    const int64_t row = int64_t{top} - row_of(key), column = int64_t{column_of(key)} - left;
    out.values[static_cast<size_t>(row * out.width + column)] =
        content == MapImageContent::kHeight ? pixel.height : pixel.reflectivity / pixel.count;
  }
  return out;
}

Result<MapDrawing> MapImage::draw(MapImageContent content) const {
  const auto raster = this->raster(content);
  if (!raster) return tl::unexpected(raster.error());
  std::vector<float> values;
  for (const float value : raster->values) {
    if (!std::isnan(value)) values.push_back(value);
  }
  constexpr double kLowest = 0.02, kHighest = 0.98;
  const float low = percentile(values, kLowest), high = percentile(values, kHighest);
  MapDrawing drawing{{}, low, high};
  CameraFrame& image = drawing.image;
  image.width = static_cast<int>(raster->width);
  image.height = static_cast<int>(raster->height);
  image.format = PixelFormat::kGrey8;
  for (const float value : raster->values) {
    const float share = high > low ? std::clamp((value - low) / (high - low), 0.F, 1.F) : 1.F;
    image.pixels.push_back(std::isnan(value) ? uint8_t{0}
                                             : static_cast<uint8_t>(1 + std::lround(254 * share)));
  }
  return drawing;
}

}  // namespace infuse::daemon

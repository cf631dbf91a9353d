#include "daemon/mapping/geotiff_file.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <span>
#include <vector>

namespace infuse::daemon {
namespace {

static_assert(std::endian::native == std::endian::little, "TIFF is written in memory order");

constexpr int64_t kStripBytes = 1 << 20;  // before compression, about

enum FieldType : uint16_t { kAscii = 2, kShort = 3, kLong = 4, kDouble = 12 };

/// A field of the image file directory: four bytes of values in place, or more elsewhere.
struct Field {
  uint16_t tag;
  FieldType type;
  uint32_t count;
  std::string values;
};

template <class T>
void append_number(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

template <class T>
Field field(uint16_t tag, FieldType type, std::span<const T> values) {
  Field out{tag, type, static_cast<uint32_t>(values.size()), {}};
  for (const T value : values) append_number(out.values, value);
  return out;
}
Field short_field(uint16_t tag, uint16_t value) {
  return field<uint16_t>(tag, kShort, std::span(&value, 1));
}
Field long_field(uint16_t tag, uint32_t value) {
  return field<uint32_t>(tag, kLong, std::span(&value, 1));
}

Result<std::vector<std::string>> deflate_strips(const MapRaster& raster, int64_t rows_per_strip) {
  std::vector<std::string> strips;
  for (int64_t row = 0; row < raster.height; row += rows_per_strip) {
    const int64_t rows = std::min(rows_per_strip, raster.height - row);
    const auto* data = reinterpret_cast<const Bytef*>(raster.values.data() + row * raster.width);
    const auto size = static_cast<uLong>(rows * raster.width) * sizeof(float);
    uLongf bound = compressBound(size);
    std::string strip(bound, '\0');
    const int code = compress2(reinterpret_cast<Bytef*>(strip.data()), &bound, data, size, 6);
    if (code != Z_OK) return fail("the raster cannot be compressed");
    strip.resize(bound + bound % 2);  // strips begin at even offsets
    strips.push_back(std::move(strip));
  }
  return strips;
}

}  // namespace

Result<std::string> format_geotiff(const MapRaster& raster,
                                   const std::optional<MapProjection>& projection) {
  if (raster.values.empty()) return fail("the map has no points");
  const int64_t rows_per_strip =
      std::max<int64_t>(1, kStripBytes / (raster.width * static_cast<int64_t>(sizeof(float))));
  auto strips = deflate_strips(raster, rows_per_strip);
  if (!strips) return tl::unexpected(strips.error());
  std::vector<uint32_t> offsets(strips->size()), sizes;
  for (const std::string& strip : *strips) sizes.push_back(static_cast<uint32_t>(strip.size()));

  const std::array<double, 3> scale{raster.pixel, raster.pixel, 0};
  const std::array<double, 6> tie_point{0, 0, 0, raster.left, raster.top, 0};
  std::vector<uint16_t> keys{1, 1, 0, 1, 1025, 0, 1, 1};  // GTRasterType: pixel is area
  if (projection) {
    const auto of_system = projection->geo_keys();
    keys.assign(of_system.begin(), of_system.end());
  }
  std::vector<Field> fields{
      long_field(256, static_cast<uint32_t>(raster.width)),
      long_field(257, static_cast<uint32_t>(raster.height)),
      short_field(258, 32),                                                // bits per sample
      short_field(259, 8),                                                 // compression: deflate
      short_field(262, 1),                                                 // dark is small
      field<uint32_t>(273, kLong, offsets),                                // of strips; set below
      short_field(277, 1),                                                 // samples per pixel
      long_field(278, static_cast<uint32_t>(rows_per_strip)),              //
      field<uint32_t>(279, kLong, sizes),                                  // of strips
      short_field(339, 3),                                                 // floating point
      field<double>(33550, kDouble, scale),                                // ModelPixelScale
      field<double>(33922, kDouble, tie_point),                            // ModelTiepoint
      field<uint16_t>(34735, kShort, std::span(keys).first(keys.size())),  // GeoKeyDirectory
      {42113, kAscii, 4, std::string("nan\0", 4)},                         // nodata
  };
  // Header, directory, values that do not fit into it, strips.
  const size_t directory = 8;
  size_t at = directory + 2 + 12 * fields.size() + 4;
  for (const Field& f : fields) at += f.values.size() > 4 ? f.values.size() : 0;
  for (size_t k = 0; k < offsets.size(); ++k) {
    offsets[k] = static_cast<uint32_t>(at);
    at += sizes[k];
  }
  fields[5] = field<uint32_t>(273, kLong, offsets);

  std::string bytes = "II";
  append_number<uint16_t>(bytes, 42);
  append_number<uint32_t>(bytes, static_cast<uint32_t>(directory));
  append_number(bytes, static_cast<uint16_t>(fields.size()));
  std::string values;
  const size_t values_at = directory + 2 + 12 * fields.size() + 4;
  for (const Field& f : fields) {
    append_number(bytes, f.tag);
    append_number<uint16_t>(bytes, f.type);
    append_number(bytes, f.count);
    if (f.values.size() > 4) {
      append_number(bytes, static_cast<uint32_t>(values_at + values.size()));
      values += f.values;
    } else {
      bytes += f.values;
      bytes.append(4 - f.values.size(), '\0');
    }
  }
  append_number<uint32_t>(bytes, 0);  // no further directory
  bytes += values;
  for (const std::string& strip : *strips) bytes += strip;
  return bytes;
}

}  // namespace infuse::daemon

#include "daemon/mapping/las_file.hpp"

#include <Eigen/Core>
#include <GeographicLib/UTMUPS.hpp>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "drivers/gnss/local_frame.hpp"

namespace infuse::daemon {
namespace {

static_assert(std::endian::native == std::endian::little, "LAS is written in memory order");

constexpr double kLasStep = 1e-3;  // m
constexpr uint16_t kHeaderBytes = 227, kPointBytes = 20;

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// A text in a field of `size` bytes.
void append_text(std::string& bytes, std::string text, size_t size) {
  text.resize(size, '\0');
  bytes += text;
}

/// Coordinates to write, and the code of their system in the EPSG register; 0: the map's frame.
struct Coordinates {
  std::vector<Eigen::Vector3d> points;
  uint16_t epsg = 0;
};

Coordinates coordinates_of(const mapping::Submap& cloud, const std::optional<MapOrigin>& origin) {
  Coordinates out;
  out.points.reserve(cloud.size());
  for (size_t i = 0; i < cloud.size(); ++i)
    out.points.emplace_back(cloud.x[i], cloud.y[i], cloud.z[i]);
  if (!origin) return out;
  const gnss::LocalFrame frame(origin->latitude, origin->longitude, origin->altitude);
  const int zone = GeographicLib::UTMUPS::StandardZone(origin->latitude, origin->longitude);
  const bool north = origin->latitude >= 0;
  out.epsg = static_cast<uint16_t>((north ? 32600 : 32700) + zone);
  for (Eigen::Vector3d& point : out.points) {
    double latitude = 0, longitude = 0, altitude = 0, x = 0, y = 0;
    frame.Reverse(point.x(), point.y(), point.z(), latitude, longitude, altitude);
    int same_zone = 0;
    bool point_north = north;
    GeographicLib::UTMUPS::Forward(latitude, longitude, same_zone, point_north, x, y, zone);
    if (point_north != north) y += north ? -1e7 : 1e7;  // a map across the equator
    point = {x, y, altitude};
  }
  return out;
}

/// The record that names the coordinate system (GeoTIFF keys).
std::string projection_record(uint16_t epsg) {
  std::string bytes;
  append<uint16_t>(bytes, 0);
  append_text(bytes, "LASF_Projection", 16);
  append<uint16_t>(bytes, 34735);                         // GeoKeyDirectoryTag
  const std::array<uint16_t, 20> keys{1,    1, 0, 4,      // version, revision, number of keys
                                      1024, 0, 1, 1,      // GTModelType: projected
                                      1025, 0, 1, 1,      // GTRasterType: pixel is area
                                      3072, 0, 1, epsg,   // ProjectedCSType
                                      3076, 0, 1, 9001};  // ProjLinearUnits: metre
  append(bytes, static_cast<uint16_t>(sizeof(keys)));
  append_text(bytes, "WGS 84 / UTM", 32);
  for (const uint16_t key : keys) append(bytes, key);
  return bytes;
}

}  // namespace

Result<std::string> format_cloud_las(const mapping::Submap& cloud,
                                     const std::optional<MapOrigin>& origin) {
  if (cloud.size() == 0) return fail("the cloud has no points");
  if (cloud.size() > std::numeric_limits<uint32_t>::max()) return fail("too many points for LAS");
  if (origin && !(origin->latitude >= -80 && origin->latitude < 84)) {
    return fail("the map is too near a pole for UTM coordinates");
  }
  const Coordinates coordinates = coordinates_of(cloud, origin);
  Eigen::Vector3d low = coordinates.points[0], high = low;
  for (const Eigen::Vector3d& point : coordinates.points) {
    if (!point.allFinite()) return fail("a point of the cloud is not finite");
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  const Eigen::Vector3d offset = low.array().floor();
  if (!((high - offset).maxCoeff() < kLasStep * std::numeric_limits<int32_t>::max())) {
    return fail("a coordinate is too far from the others for LAS");
  }
  const std::string projection = origin ? projection_record(coordinates.epsg) : "";
  const auto points = static_cast<uint32_t>(cloud.size());

  std::string bytes = "LASF";
  bytes.reserve(kHeaderBytes + projection.size() + cloud.size() * kPointBytes);
  append<uint32_t>(bytes, 0);  // source, encoding
  append_text(bytes, "", 16);  // project
  append<uint8_t>(bytes, 1);   // version
  append<uint8_t>(bytes, 2);
  append_text(bytes, "EXTRACTION", 32);
  append_text(bytes, "infuse map export", 32);
  append<uint32_t>(bytes, 0);  // date: same bytes every day
  append<uint16_t>(bytes, kHeaderBytes);
  append(bytes, static_cast<uint32_t>(kHeaderBytes + projection.size()));
  append<uint32_t>(bytes, origin ? 1 : 0);  // records
  append<uint8_t>(bytes, 0);                // point format
  append<uint16_t>(bytes, kPointBytes);
  append(bytes, points);
  for (const uint32_t returns : {points, 0U, 0U, 0U, 0U}) append(bytes, returns);
  for (int axis = 0; axis < 3; ++axis) append(bytes, kLasStep);
  for (int axis = 0; axis < 3; ++axis) append(bytes, offset[axis]);
  for (int axis = 0; axis < 3; ++axis) {
    append(bytes, high[axis]);
    append(bytes, low[axis]);
  }
  bytes += projection;
  for (size_t i = 0; i < cloud.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      append(bytes, static_cast<int32_t>(
                        std::lround((coordinates.points[i][axis] - offset[axis]) / kLasStep)));
    }
    append(bytes,
           static_cast<uint16_t>(std::lround(65535 * std::clamp(cloud.reflectivity[i], 0.F, 1.F))));
    append<uint8_t>(bytes, 0x09);  // first of one return
    append<uint8_t>(bytes, 0);     // class: never classified
    append<uint32_t>(bytes, 0);    // scan angle, user data, source
  }
  return bytes;
}

}  // namespace infuse::daemon

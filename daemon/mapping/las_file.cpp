#include "daemon/mapping/las_file.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

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

/// Coordinates to write: UTM, or those of the map's frame.
std::vector<Eigen::Vector3d> coordinates_of(const mapping::Submap& cloud,
                                            const std::optional<MapProjection>& projection) {
  std::vector<Eigen::Vector3d> out;
  out.reserve(cloud.size());
  for (size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p(cloud.x[i], cloud.y[i], cloud.z[i]);
    out.push_back(projection ? projection->project(p) : p);
  }
  return out;
}

/// The record that names the coordinate system.
std::string projection_record(const MapProjection& projection) {
  std::string bytes;
  append<uint16_t>(bytes, 0);
  append_text(bytes, "LASF_Projection", 16);
  append<uint16_t>(bytes, 34735);  // GeoKeyDirectoryTag
  const auto keys = projection.geo_keys();
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
  std::optional<MapProjection> map_projection;
  if (origin) {
    auto made = MapProjection::create(*origin);
    if (!made) return tl::unexpected(made.error());
    map_projection = *made;
  }
  const std::vector<Eigen::Vector3d> coordinates = coordinates_of(cloud, map_projection);
  Eigen::Vector3d low = coordinates[0], high = low;
  for (const Eigen::Vector3d& point : coordinates) {
    if (!point.allFinite()) return fail("a point of the cloud is not finite");
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  const Eigen::Vector3d offset = low.array().floor();
  if (!((high - offset).maxCoeff() < kLasStep * std::numeric_limits<int32_t>::max())) {
    return fail("a coordinate is too far from the others for LAS");
  }
  const std::string projection = map_projection ? projection_record(*map_projection) : "";
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
      append(bytes,
             static_cast<int32_t>(std::lround((coordinates[i][axis] - offset[axis]) / kLasStep)));
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

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/gnss/local_frame.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// Origin of a georeferenced map: its frame is east, north, up there (WGS 84).
struct MapOrigin {
  double latitude = 0, longitude = 0;  ///< deg
  double altitude = 0;                 ///< m, as GNSS stated it
};

/// Coordinates of a georeferenced map in the UTM zone of its origin.
class MapProjection {
 public:
  /// Fails near the poles, where UTM ends.
  static Result<MapProjection> create(const MapOrigin& origin);

  /// Code of the coordinate system in the EPSG register: 326xx in the north, 327xx in the south.
  uint16_t epsg() const { return static_cast<uint16_t>((north_ ? 32600 : 32700) + zone_); }

  /// Easting, northing and altitude, m, of a point in the frame of the map.
  Eigen::Vector3d project(const Eigen::Vector3d& p_map) const;

  /// Number of `geo_keys`.
  static constexpr size_t kGeoKeys = 20;

  /// The record that names the system (GeoKeyDirectory of GeoTIFF, which LAS uses too).
  std::array<uint16_t, kGeoKeys> geo_keys() const;

 private:
  MapProjection(const MapOrigin& origin, int zone);

  gnss::LocalFrame frame_;
  int zone_;
  bool north_;
};

}  // namespace infuse::daemon

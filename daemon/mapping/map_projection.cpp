#include "daemon/mapping/map_projection.hpp"

#include <GeographicLib/UTMUPS.hpp>

namespace infuse::daemon {

MapProjection::MapProjection(const MapOrigin& origin, int zone)
    : frame_(origin.latitude, origin.longitude, origin.altitude),
      zone_(zone),
      north_(origin.latitude >= 0) {}

Result<MapProjection> MapProjection::create(const MapOrigin& origin) {
  if (!(origin.latitude >= -80 && origin.latitude < 84)) {
    return fail("the map is too near a pole for UTM coordinates");
  }
  return MapProjection(origin,
                       GeographicLib::UTMUPS::StandardZone(origin.latitude, origin.longitude));
}

Eigen::Vector3d MapProjection::project(const Eigen::Vector3d& p_map) const {
  double latitude = 0, longitude = 0, altitude = 0, x = 0, y = 0;
  frame_.Reverse(p_map.x(), p_map.y(), p_map.z(), latitude, longitude, altitude);
  int same_zone = 0;
  bool north = north_;
  GeographicLib::UTMUPS::Forward(latitude, longitude, same_zone, north, x, y, zone_);
  if (north != north_) y += north_ ? -1e7 : 1e7;  // a map across the equator
  return {x, y, altitude};
}

std::array<uint16_t, MapProjection::kGeoKeys> MapProjection::geo_keys() const {
  return {1,    1, 0, 4,       // version, revision, number of keys
          1024, 0, 1, 1,       // GTModelType: projected
          1025, 0, 1, 1,       // GTRasterType: pixel is area
          3072, 0, 1, epsg(),  // ProjectedCSType
          3076, 0, 1, 9001};   // ProjLinearUnits: metre
}

}  // namespace infuse::daemon

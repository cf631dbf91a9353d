#pragma once

#include <vector>

#include "fusion/places/place_matcher.hpp"
#include "tests/fusion/places/invented_places.hpp"

namespace infuse::places {

inline const InventedStreet& street() {
  static const InventedStreet made(5);
  return made;
}

/// Map of the first metres of a street: a keyframe every 2 m.
inline PlaceMap make_map(const InventedStreet& street, double length) {
  PlaceMap map;
  map.T_vehicle_lidar = lidar_above();
  std::vector<mapping::Submap> clouds;
  for (double along = 0; along <= length; along += 2) {
    map.T_map_vehicle.push_back(on_street(along, 0, 0));
    clouds.push_back(
        street.seen_from(map.T_map_vehicle.back() * lidar_above(), clouds.size() + 100));
    map.descriptors.push_back(describe_place(clouds.back().points(), map.T_vehicle_lidar));
  }
  map.read_cloud = [clouds = std::move(clouds)](size_t k) -> Result<mapping::Submap> {
    return clouds[k];
  };
  return map;
}

/// The same with the street a second time, 500 m beside.
inline PlaceMap make_map_twice(const InventedStreet& street, double length) {
  PlaceMap map = make_map(street, length);
  const size_t once = map.T_map_vehicle.size();
  for (size_t k = 0; k < once; ++k) {
    map.T_map_vehicle.push_back(Eigen::Translation3d(0, 500, 0) * map.T_map_vehicle[k]);
    map.descriptors.push_back(map.descriptors[k]);
  }
  map.read_cloud = [read = map.read_cloud, once](size_t k) { return read(k % once); };
  return map;
}

}  // namespace infuse::places

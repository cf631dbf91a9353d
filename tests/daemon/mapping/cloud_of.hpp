#pragma once

#include <array>
#include <initializer_list>

#include "fusion/mapping/submap.hpp"

namespace infuse::daemon {

/// Points given by x, y, z, m, and reflectivity.
inline mapping::Submap cloud_of(std::initializer_list<std::array<float, 4>> points) {
  mapping::Submap cloud;
  for (const auto& [x, y, z, reflectivity] : points) {
    cloud.x.push_back(x);
    cloud.y.push_back(y);
    cloud.z.push_back(z);
    cloud.reflectivity.push_back(reflectivity);
  }
  return cloud;
}

}  // namespace infuse::daemon

#pragma once

#include <string>
#include <vector>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// What the places of a drive are called.
struct PlaceList {
  std::vector<std::string> names;  ///< file name of the image, or number of the sweep
  std::vector<Stamp> stamps;       ///< one each; empty for a folder of images
};

}  // namespace infuse::daemon

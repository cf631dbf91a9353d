#pragma once

#include <string>

namespace infuse::daemon {

/// Arguments of `infuse map locate`.
struct MapLocateArguments {
  std::string map, drive, output, lidar;
  bool json = false;
};

/// Finds a drive on a map from nothing and tracks it there; writes the poses as TUM. Returns the
/// exit code.
int run_map_locate(const MapLocateArguments& arguments);

}  // namespace infuse::daemon

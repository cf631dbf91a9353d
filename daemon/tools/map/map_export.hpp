#pragma once

#include <cstddef>
#include <string>

namespace infuse::daemon {

/// What `infuse map export` was asked for.
struct MapExportArguments {
  std::string map, output;
  double voxel = 0;  ///< m; 0: the format's own
  std::string show = "intensity";
  bool without_moving = false;  ///< leave out the points of what moved
  size_t drive = 1;             ///< whose trajectory, of a merged map
};

/// Runs `infuse map export`: reads a complete map and writes it as one file.
int run_map_export(const MapExportArguments& arguments);

}  // namespace infuse::daemon

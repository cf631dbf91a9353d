#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>

#include "daemon/protocol/json.hpp"
#include "drivers/measurement/error.hpp"

namespace infuse::daemon {

/// How sharp the sweeps of a drive are on top of each other, as occupied voxels of 10 cm for each
/// point: a motion that deskews wrongly spreads the points of one wall over more voxels. All clouds
/// are placed by one trajectory, that of the lidar alone, at the middles of the sweeps.
struct Sharpness {
  size_t sweeps = 0;        ///< that are compared: with a pose, and deskewed in all ways
  size_t not_deskewed = 0;  ///< left out: not deskewed by the drive's odometry
  size_t points = 0;
  double raw = 0;       ///< voxels per point, as measured
  double deskewed = 0;  ///< deskewed as infused does, by all sources of the drive
  double lidar = 0;     ///< deskewed by the lidar's own motion
  /// Ratio of deskewed to raw in the first and the second half of the drive.
  std::array<double, 2> halves{};
  /// Probability of a gain over raw as large as this by chance, from parts of 10 sweeps (paired t
  /// test, one-sided); 1 with fewer than three parts.
  double p = 1;
};

/// Measures the first lidar of a drive, or the one of that name. Errors: the drive cannot be read,
/// there is no such lidar, no sweep can be compared.
Result<Sharpness> measure_sharpness(const std::filesystem::path& drive, const std::string& lidar);

Json to_json(const Sharpness& sharpness);
std::string to_text(const Sharpness& sharpness);

}  // namespace infuse::daemon

#pragma once

#include <string>
#include <vector>

#include "daemon/tools/places/place_list.hpp"
#include "drivers/measurement/error.hpp"
#include "fusion/places/place_descriptor.hpp"
#include "fusion/places/visual/scan_words.hpp"

namespace infuse::daemon {

/// What is read of a drive's sweeps.
struct LidarPlacesRequest {
  std::string lidar;   ///< name, if there are several
  size_t every = 5;    ///< sweeps from one place to the next
  bool words = false;  ///< features for the total mutual information too
  bool grey = false;   ///< with the grey levels of the lidar's cameras
};

/// Sweeps of a drive, described.
struct LidarPlaces {
  PlaceList list;
  std::vector<places::PlaceDescriptor> shapes;
  std::vector<places::ScanWords> words;  ///< if requested
};

/// Reads every so many sweeps of a drive or capture, deskewed as `infused` would, without what fog
/// and spray return. Errors: a drive that cannot be read or has no such lidar or no sweep; with
/// `grey`, a sweep whose cameras have no image within 50 ms.
Result<LidarPlaces> read_lidar_places(const std::string& path, const LidarPlacesRequest& request);

}  // namespace infuse::daemon

#pragma once

#include <memory>
#include <optional>

#include "daemon/pipeline/map_localiser.hpp"
#include "daemon/pipeline/street_map_tracker.hpp"
#include "daemon/streetmap/street_map_file.hpp"

namespace infuse::daemon {

/// Maps that were opened.
struct Maps {
  StreetMapFile street_map;                ///< empty: none
  std::optional<places::PlaceMap> places;  ///< of keyframes; nothing: none
};

/// What finds the vehicle on maps. Null: without such a map.
struct MapTasks {
  std::unique_ptr<StreetMapTracker> street_map;
  std::unique_ptr<MapLocaliser> places;
};

}  // namespace infuse::daemon

#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "fusion/mapping/closure_check.hpp"
#include "fusion/mapping/closure_search.hpp"
#include "fusion/mapping/earth_fit.hpp"
#include "fusion/places/join_search.hpp"
#include "fusion/places/place_selection.hpp"

namespace infuse::daemon {

/// Settings of a map that is made from a drive.
struct MapSettings {
  mapping::KeyframeOptions keyframes;
  mapping::SubmapOptions submaps;
  mapping::ClosureSearchOptions search;
  mapping::ClosureCheckOptions check;
  places::JoinOptions join;
  mapping::EarthFitOptions earth;
  places::PlaceSelectionOptions kept_clouds;
  double max_unmeasured = 0.03;   ///< share of the sweeps whose motion no sensor measured, …
  double max_unregistered = 0.1;  ///< … or the lidar did not; more make a map that is not usable
  bool close_loops = true;
  bool use_gnss = true;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// The settings as an object; units as in their structs.
nlohmann::ordered_json to_json(const MapSettings& settings);

}  // namespace infuse::daemon

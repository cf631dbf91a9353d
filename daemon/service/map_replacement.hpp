#pragma once

#include <functional>
#include <stop_token>

#include "daemon/config/config.hpp"
#include "daemon/mapping/map_folder.hpp"
#include "daemon/service/map_watch.hpp"
#include "daemon/streetmap/street_map_file.hpp"
#include "fusion/places/place_matcher.hpp"

namespace infuse::daemon {

/// How a new street map takes the place of the one in use: the file is read, and handed to `use` if
/// its bytes are others. `config` outlives what is returned.
MapWatch::Replace replace_street_map(
    const Config& config,
    std::function<void(const StreetMapFile& map, const std::stop_token& stop)> use);

/// How a new map of keyframes takes the place of the one in use, whose clouds are in `folder`: each
/// of its clouds is read, and it is handed to `use` if it, or its folder, is another. `config`
/// outlives what is returned.
MapWatch::Replace replace_place_map(
    const Config& config, MapFolder::Id folder,
    std::function<void(places::PlaceMap map, const std::stop_token& stop)> use);

}  // namespace infuse::daemon

#include "daemon/service/map_replacement.hpp"

#include <string>
#include <utility>

#include "daemon/mapping/place_map.hpp"
#include "daemon/service/daemon_host.hpp"

namespace infuse::daemon {

MapWatch::Replace replace_street_map(
    const Config& config,
    std::function<void(const StreetMapFile& map, const std::stop_token& stop)> use) {
  return [&config, use = std::move(use)](const std::string& in_use, const std::stop_token& stop) {
    return open_street_map(config).map([&](const StreetMapFile& map) {
      if (map.digest != in_use && !stop.stop_requested()) use(map, stop);
      return map.digest;
    });
  };
}

MapWatch::Replace replace_place_map(
    const Config& config, MapFolder::Id folder,
    std::function<void(places::PlaceMap map, const std::stop_token& stop)> use) {
  return
      [&config, folder, use = std::move(use)](
          const std::string& in_use, const std::stop_token& stop) mutable -> Result<std::string> {
        auto opened = open_place_map(config);
        if (!opened) return tl::unexpected(opened.error());
        OpenedPlaces& places = **opened;
        if (places.digest == in_use && places.folder == folder) return in_use;
        if (const auto whole = check_clouds(places.map, stop); !whole) {
          return tl::unexpected(whole.error());
        }
        if (stop.stop_requested()) return in_use;
        use(std::move(places.map), stop);
        folder = places.folder;
        return places.digest;
      };
}

}  // namespace infuse::daemon

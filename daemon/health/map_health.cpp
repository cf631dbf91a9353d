#include "daemon/health/map_health.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {
namespace {

constexpr Alert<MapStatus> kMapAlerts[] = {
    {{"not_on_map", Level::kWarn, Delays::kBoth,
      "The vehicle is not found on the map of keyframes. Drive on along streets of the map; check "
      "directory in [map], and the lidar's mount in rig.toml."},
     [](const MapStatus& status) -> std::optional<Problem> {
       if (status.state != places::LocaliserState::kLost) return {};
       return Problem{
           fmt::format("the vehicle is not found on the map: {}", status.reason),
           "drive on along streets of the map; if the alert stays, check that [map] names the map "
           "of this place and that the lidar is mounted as rig.toml states"};
     }},
};

}  // namespace

std::span<const Alert<MapStatus>> map_alerts() { return kMapAlerts; }

}  // namespace infuse::daemon

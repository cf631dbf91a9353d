#include "daemon/health/map_health.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {

MapHealth::MapHealth(const HealthOptions& options)
    : conditions_{{"not_on_map", Level::kWarn, options.raise_after, options.clear_after}} {}

const Conditions& MapHealth::update(Stamp now, const MapStatus& status) {
  CheckResult lost;
  if (status.state == places::LocaliserState::kLost) {
    lost = {true, fmt::format("the vehicle is not found on the map: {}", status.reason),
            "drive on, where the map has been driven; if it stays so, check that [map] names the "
            "map of this place and that the lidar is mounted as rig.toml says"};
  }
  conditions_.update({lost}, now);
  return conditions_;
}

}  // namespace infuse::daemon

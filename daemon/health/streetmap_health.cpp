#include "daemon/health/streetmap_health.hpp"

#include <spdlog/fmt/fmt.h>

#include <string_view>

namespace infuse::daemon {

StreetMapHealth::StreetMapHealth(const HealthOptions& options)
    : conditions_{{"lost", Level::kError, options.raise_after, options.clear_after},
                  {"map_mismatch", Level::kWarn, options.raise_after, options.clear_after}} {}

const Conditions& StreetMapHealth::update(Stamp now, const StreetMapStatus& status) {
  CheckResult lost, mismatch;
  const std::string place =
      fmt::format("near {:.0f} m east, {:.0f} m north of the map's origin", status.x, status.y);
  if (std::string_view(status.state) == "LOST") {
    lost = {true, fmt::format("lost on the street map {}: {}", place, status.reason),
            "it looks for its place; give a start in [streetmap] or a satellite receiver"};
  }
  if (status.mismatch) {
    mismatch = {true, fmt::format("what is seen does not fit the street map {}", place),
                "is the map up to date there? make it anew with infuse streetmap"};
  }
  conditions_.update({lost, mismatch}, now);
  return conditions_;
}

}  // namespace infuse::daemon

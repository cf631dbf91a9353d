#include "daemon/health/streetmap_health.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {

StreetMapHealth::StreetMapHealth(const HealthOptions& options)
    : conditions_{{"lost", Level::kError, options.raise_after, options.clear_after},
                  {"map_mismatch", Level::kWarn, options.raise_after, options.clear_after}} {}

const Conditions& StreetMapHealth::update(Stamp now, const StreetMapStatus& status) {
  CheckResult lost, mismatch;
  const std::string place =
      fmt::format("near {:.0f} m east, {:.0f} m north of the map origin", status.x, status.y);
  if (status.state == streetmap::TrackState::kLost) {
    const std::string drive_on =
        status.hypotheses > 0 ? "drive on: all streets are searched, and turns decide; or " : "";
    lost = {true, fmt::format("position on the street map lost {}: {}", place, status.reason),
            drive_on +
                "set an initial pose in [streetmap], or connect a GNSS receiver; if one is "
                "connected, check its antenna, and whether the map is that of this place"};
  }
  if (status.mismatch) {
    mismatch = {true, fmt::format("observations do not match the street map {}", place),
                "check that the map is up to date; rebuild it with infuse streetmap"};
  }
  conditions_.update({lost, mismatch}, now);
  return conditions_;
}

}  // namespace infuse::daemon

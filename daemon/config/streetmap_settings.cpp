#include "daemon/config/streetmap_settings.hpp"

#include <cmath>
#include <numbers>

namespace infuse::daemon {

std::optional<std::string> StreetMapSettings::invalid() const {
  if (auto wrong = tracker.invalid()) return wrong;
  if (!(update_hz > 0 && update_hz <= 50)) return "update_hz must be between 0 and 50";
  if (!(initial_sigma > 0 && initial_sigma <= 1000)) return "sigma must be between 0 and 1000 m";
  if (!(initial_yaw_sigma > 0 && initial_yaw_sigma <= 4)) {
    return "yaw_sigma_deg must be between 0 and 229";
  }
  if (initial_pose && !(std::abs(initial_pose->x) < 1e7 && std::abs(initial_pose->y) < 1e7)) {
    return "x, y lies more than 10000 km from the map origin";
  }
  if (initial_pose && initial_location) return "either x and y or lat and lon can be given";
  constexpr double kPi = std::numbers::pi;
  if (initial_location && !(std::abs(initial_location->latitude) <= kPi / 2 &&
                            std::abs(initial_location->longitude) <= kPi)) {
    return "lat must be between -90 and 90, lon between -180 and 180 degrees";
  }
  return std::nullopt;
}

}  // namespace infuse::daemon

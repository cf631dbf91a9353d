#include "daemon/config/streetmap_settings.hpp"

#include <cmath>
#include <numbers>

#include "drivers/gnss/local_frame.hpp"
#include "drivers/measurement/angles.hpp"

namespace infuse::daemon {

std::optional<std::string> StreetMapSettings::invalid() const {
  if (auto wrong = tracker.invalid()) return wrong;
  if (!(update_hz > 0 && update_hz <= 50)) return "update_hz must be between 0 and 50";
  if (!(initial_sigma > 0 && initial_sigma <= 1000)) return "sigma must be between 0 and 1000 m";
  if (!(initial_yaw_sigma > 0 && initial_yaw_sigma <= 4)) {
    return "yaw_sigma_deg must be between 0 and 229";
  }
  if (initial_pose && !(std::isfinite(initial_pose->x) && std::isfinite(initial_pose->y)))
    return "x and y must be finite";
  if (initial_pose && initial_location) return "either x and y or lat and lon can be given";
  constexpr double kPi = std::numbers::pi;
  if (initial_location && !(std::abs(initial_location->latitude) <= kPi / 2 &&
                            std::abs(initial_location->longitude) <= kPi)) {
    return "lat must be between -90 and 90, lon between -180 and 180 degrees";
  }
  return std::nullopt;
}

std::optional<StatedStart> stated_start(const StreetMapSettings& settings,
                                        const streetmap::MapFrame& frame) {
  constexpr double kPi = std::numbers::pi;
  const auto start = [&](const Eigen::Vector2d& place, const std::optional<double>& yaw) {
    const double any = kPi / std::numbers::sqrt3;  // of the uniform distribution of all headings
    return StatedStart{{place.x(), place.y(), wrap_angle(yaw.value_or(0))},
                       yaw ? settings.initial_yaw_sigma : any};
  };
  if (settings.initial_pose) {
    const InitialPose& pose = *settings.initial_pose;
    return start({pose.x, pose.y}, pose.yaw);
  }
  if (!settings.initial_location || !frame.georeferenced) return std::nullopt;
  const InitialLocation& place = *settings.initial_location;
  const gnss::LocalFrame local = gnss::make_local_frame(frame.latitude, frame.longitude);
  const auto heading = place.heading;
  return start(gnss::to_local(local, place.latitude, place.longitude).head<2>(),
               heading ? std::optional(kPi / 2 - *heading) : std::nullopt);
}

}  // namespace infuse::daemon

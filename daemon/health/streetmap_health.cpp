#include "daemon/health/streetmap_health.hpp"

#include <spdlog/fmt/fmt.h>

namespace infuse::daemon {
namespace {

using StreetMapProblem = std::optional<Problem>;

std::string place_text(const StreetMapStatus& status) {
  if (!status.on_map) return "";
  return fmt::format(" near {:.0f} m east, {:.0f} m north of the map origin", status.x, status.y);
}

// Places that look alike: "; it is at one of 2 places: 60, 40 %".
std::string places_text(const StreetMapStatus& status) {
  const auto places = status.places.all();
  if (places.size() < 2) return "";
  std::string text = fmt::format("; it is at one of {} places:", places.size());
  for (const streetmap::PossiblePlace& place : places) {
    text += fmt::format("{} {:.0f}", &place == &places.front() ? "" : ",", 100 * place.probability);
  }
  return text + " %";
}

constexpr Alert<StreetMapStatus> kStreetMapAlerts[] = {
    {{"lost", Level::kError, Delays::kBoth,
      "The position on the street map is lost. Drive on, with turns; or set an initial pose, or "
      "check the GNSS receiver's antenna and that the map is of this place."},
     [](const StreetMapStatus& status) -> StreetMapProblem {
       if (status.state != streetmap::TrackState::kLost) return {};
       const std::string drive_on =
           status.hypotheses > 0 ? "drive on: all streets are searched, and turns decide; or " : "";
       return Problem{
           fmt::format("position on the street map lost{}: {}{}", place_text(status), status.reason,
                       places_text(status)),
           drive_on +
               "set an initial pose in [streetmap], or connect a GNSS receiver; if one is "
               "connected, check its antenna, and whether the map is that of this place"};
     }},
    {{"map_mismatch", Level::kWarn, Delays::kBoth,
      "What the sensors see does not match the map here. Check that it is up to date; make it "
      "again with `infuse streetmap`."},
     [](const StreetMapStatus& status) -> StreetMapProblem {
       if (!status.mismatch) return {};
       return Problem{"observations do not match the street map" + place_text(status),
                      "check that the map is up to date; rebuild it with infuse streetmap"};
     }},
    {{"gnss_contradicts", Level::kWarn, Delays::kBoth,
      "GNSS fixes are off the pose on the street map by more than the map and the receiver "
      "explain. "
      "Check the receiver's antenna, and that the initial pose is right."},
     [](const StreetMapStatus& status) -> StreetMapProblem {
       if (!status.gnss_contradicts || !status.gnss_offset) return {};
       return Problem{fmt::format("GNSS fixes are {:.0f} m off the pose on the street map",
                                  status.gnss_offset->norm()),
                      "check the receiver's antenna, and the initial pose in [streetmap]"};
     }},
};

}  // namespace

std::span<const Alert<StreetMapStatus>> streetmap_alerts() { return kStreetMapAlerts; }

}  // namespace infuse::daemon

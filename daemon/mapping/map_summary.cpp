#include <spdlog/fmt/fmt.h>

#include "daemon/mapping/map_finish.hpp"
#include "drivers/measurement/angles.hpp"

namespace infuse::daemon {

MapJson to_json(const MapSummary& summary) {
  MapJson rejected = MapJson::object();
  for (const auto& [reason, count] : summary.rejected) rejected[reason] = count;
  return {{"drives", summary.drives},
          {"keyframes", summary.keyframes},
          {"clouds", summary.clouds},
          {"sweeps", summary.sweeps},
          {"unregistered_sweeps", summary.unregistered},
          {"unmeasured_sweeps", summary.unmeasured},
          {"length_m", summary.way},
          {"closures", summary.closures},
          {"rejected_closures", rejected},
          {"cost_before", summary.cost_before},
          {"cost", summary.cost},
          {"moved_m", summary.moved},
          {"tilt_sigma_deg", summary.tilt_sigma / kDegree},
          {"georeferenced", summary.georeferenced},
          {"georeference_reason", summary.position_reason},
          {"fixes", summary.fixes},
          {"rejected_fixes", summary.fixes_rejected},
          {"fixes_rms_m", summary.fix_rms},
          {"usable", summary.usable()},
          {"reason", summary.reason}};
}

std::string to_text(const MapSummary& summary) {
  std::string text = fmt::format("{} keyframes from {} sweeps, {:.1f} m, {} clouds kept",
                                 summary.keyframes, summary.sweeps, summary.way, summary.clouds);
  if (summary.drives > 1) text += fmt::format(", {} drives", summary.drives);
  if (summary.unregistered > 0) {
    text += fmt::format(", {} sweep(s) not registered, the motion of {} of them unknown",
                        summary.unregistered, summary.unmeasured);
  }
  text += fmt::format("\n  {} loop closure(s) accepted", summary.closures);
  for (const auto& [reason, count] : summary.rejected) {
    text += fmt::format("\n  {} rejected: {}", count, reason);
  }
  if (summary.closures > 0) {
    text += fmt::format("\n  cost {:.6g}, by odometry {:.6g}; keyframes moved by {:.2f} m (rms)",
                        summary.cost, summary.cost_before, summary.moved);
  }
  if (summary.georeferenced) {
    text += fmt::format("\n  georeferenced by {} of {} fixes, {:.2f} m from them (rms)",
                        summary.fixes - summary.fixes_rejected, summary.fixes, summary.fix_rms);
  } else {
    text += "\n  not georeferenced: " + summary.position_reason;
  }
  text += fmt::format("\n  upright, with a standard deviation of {:.1f}°",
                      summary.tilt_sigma / kDegree);
  return text + (summary.usable() ? "\n" : "\nnot usable: " + summary.reason + "\n");
}

}  // namespace infuse::daemon

#include "daemon/owner/drive_uses.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

namespace infuse::daemon {
namespace {

constexpr uint64_t kMinImages = 3;  // of which a calibration needs sweeps

constexpr const char* kAddOdometry =
    "add wheel speeds, a speed source, or an inertial unit and a GNSS receiver";

bool has_sensor(const Summary& summary, SensorKind kind) {
  return std::any_of(summary.sensors.begin(), summary.sensors.end(),
                     [&](const Sensor& sensor) { return sensor.id.kind == kind; });
}

DriveUse deskewing(const Summary& summary) {
  const Totals& totals = summary.totals;
  DriveUse use{.use = "deskewing", .possible = totals.deskewed_sweeps > 0, .statement = {}};
  if (totals.sweeps == 0) {
    use.statement = "there are no sweeps";
    return use;
  }
  use.statement = fmt::format("{} of {} sweeps", totals.deskewed_sweeps, totals.sweeps);
  if (totals.deskewed_sweeps < totals.sweeps)
    use.statement += fmt::format("; others: {}", totals.deskew_reason);
  if (!use.possible && !summary.has_odometry) use.statement += fmt::format("; {}", kAddOdometry);
  return use;
}

// Monitoring and calibrating need images with sweeps; in a moving vehicle, deskewed ones.
DriveUse with_images(const char* name, const Summary& summary) {
  const Totals& totals = summary.totals;
  DriveUse use{.use = name, .possible = false, .statement = {}};
  if (!has_sensor(summary, SensorKind::kCamera)) {
    use.statement = "there is no camera";
  } else if (totals.frames == 0) {
    use.statement = "it has no images";
  } else if (totals.matched_frames < kMinImages) {
    use.statement = fmt::format(
        "{} of {} images have a sweep near them; check that both are stamped by one clock",
        totals.matched_frames, totals.frames);
  } else if (totals.deskewed_sweeps == 0) {
    use.if_standing = true;
    use.statement = "no sweep is deskewed";
  } else {
    use.possible = true;
    use.statement =
        fmt::format("{} of {} images have a sweep near them", totals.matched_frames, totals.frames);
  }
  return use;
}

DriveUse tracking(const Summary& summary, bool has_map) {
  std::string missing;
  const auto need = [&](bool present, const char* what) {
    if (!present) missing += (missing.empty() ? "missing: " : ", ") + std::string(what);
  };
  need(summary.totals.sweeps > 0, "sweeps");
  need(summary.has_odometry, "odometry");
  const bool none_deskewed = summary.totals.sweeps > 0 && summary.totals.deskewed_sweeps == 0;
  need(!summary.has_odometry || !none_deskewed, "deskewed sweeps");
  need(has_map, "a street map ([map], or [streetmap] of infused.toml)");
  DriveUse use{
      .use = "tracking on a street map", .possible = missing.empty(), .statement = missing};
  if (use.possible) {
    use.statement = has_sensor(summary, SensorKind::kGnss)
                        ? "the initial pose is from GNSS"
                        : "without GNSS, give the initial pose, or all streets are searched";
  }
  return use;
}

}  // namespace

const char* answer(const DriveUse& use) {
  if (use.possible) return "yes";
  return use.if_standing ? "only if the vehicle stood still" : "no";
}

std::vector<DriveUse> drive_uses(const Summary& summary, bool has_map) {
  return {deskewing(summary), with_images("monitoring", summary),
          with_images("calibrating", summary), tracking(summary, has_map)};
}

}  // namespace infuse::daemon

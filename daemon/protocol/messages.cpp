#include "daemon/protocol/messages.hpp"

#include <algorithm>

#include "daemon/protocol/json_encoder.hpp"

namespace infuse::daemon {

Level HealthReport::level() const {
  Level worst = Level::kOk;
  for (const auto& sensor : sensors) worst = std::max(worst, sensor.status.level);
  for (const auto& stream : streams) worst = std::max(worst, stream.status.level);
  if (odometry) worst = std::max(worst, odometry->level);
  if (streetmap) worst = std::max(worst, streetmap->level);
  if (map) worst = std::max(worst, map->level);
  for (const auto& calibration : calibrations) {
    worst = std::max(worst, worst_level(calibration.findings));
  }
  return std::max(worst, worst_level(findings));
}

template <class Report>
std::string message(const Report& report) {
  return json_text(encode(report));
}

template std::string message(const VersionReport&);
template std::string message(const DevicesReport&);
template std::string message(const SweepReport&);
template std::string message(const FrameReport&);
template std::string message(const PoseReport&);
template std::string message(const CalibrationReport&);
template std::string message(const HealthReport&);
template std::string message(const AlertReport&);
template std::string message(const RecordReport&);
template std::string message(const LostReport&);
template std::string message(const AckReply&);
template std::string message(const ErrorReply&);

}  // namespace infuse::daemon

#include "daemon/command_line/summary.hpp"

#include <spdlog/fmt/fmt.h>
#include <sys/resource.h>

#include "daemon/pipeline/fusion_thread.hpp"
#include "daemon/process/process_times.hpp"
#include "drivers/measurement/angles.hpp"

namespace infuse::daemon {
namespace {

/// Events per second of drive time.
double rate(uint64_t count, Duration span) {
  return span > Duration::zero() ? static_cast<double>(count) / to_seconds(span) : 0;
}

/// "1 sweep", "2 sweeps".
std::string counted(uint64_t count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

uint64_t count_lost(const LidarCounters& counters) {
  return counters.lost_network + counters.lost_kernel;
}

uint64_t sum_over_lidars(const Summary& summary, uint64_t (*quantity)(const LidarCounters&)) {
  uint64_t total = 0;
  for (const LidarCounters& counters : summary.totals.counters.lidars) total += quantity(counters);
  return total;
}

double drive_s(const Summary& summary) {
  return to_seconds(summary.totals.now - summary.totals.start);
}

double realtime_factor(const Summary& summary) {
  return summary.host_s > 0 ? drive_s(summary) / summary.host_s : 0;
}

Json calibration_json(const CalibrationReport& report, Level level) {
  Json json = {{"camera", report.camera},
               {"state", name_of(report.state)},
               {"level", name_of(level)},
               {"evaluations", report.evaluations},
               {"evidence_nats", rounded(report.verdict.evidence)},
               {"threshold_nats", rounded(report.verdict.threshold)},
               {"axis", monitoring::name_of(report.verdict.axis)},
               {"proposed", report.proposal.has_value()}};
  if (report.verdict.fault != monitoring::CameraFault::kNone) {
    json["camera_fault"] = name_of(report.verdict.fault);
    if (!report.verdict.images_of.empty()) json["images_of"] = report.verdict.images_of;
  }
  return json;
}

/// "front: calibration CONFIRMED (ERROR): rotation about y by +0.52 ± 0.03° (evidence …)".
std::string monitoring_text(const CalibrationReport& report, Level level) {
  std::string text =
      fmt::format("  {}: calibration {} ({}), {}", report.camera, name_of(report.state),
                  name_of(level), counted(report.evaluations, "evaluation"));
  const monitoring::DriftVerdict& verdict = report.verdict;
  if (verdict.fault != monitoring::CameraFault::kNone) {
    text += "; camera fault: " + monitoring::describe_fault(verdict);
  }
  if (verdict.drifting()) {
    text += "; drift: " + monitoring::describe_drift(verdict);
  } else if (report.evaluations > 0) {
    text += fmt::format("; evidence of a drift {:.1f}, threshold {:.1f} nats", verdict.evidence,
                        verdict.threshold);
  }
  if (report.proposal) text += "; a new calibration is proposed";
  return text + "\n";
}

/// The stage that covers the whole path of a sweep; null if there is none.
const StageStats* total_stage(const Summary& summary) {
  return summary.totals.host.stages.empty() ? nullptr : &summary.totals.host.stages.back();
}

Json lidar_json(const Device& device, const LidarCounters& c, Level level) {
  return {{"device", device.name},
          {"model", device.model},
          {"model_reason", device.model_reason},
          {"endpoint", device.endpoint},
          {"level", name_of(level)},
          {"packets", c.packets},
          {"packets_hz", rounded(rate(c.packets, active_duration(c)))},
          {"packets_lost", count_lost(c)},
          {"position_packets", c.position_packets},
          {"sweeps", c.sweeps},
          {"sweeps_hz", rounded(sweep_rate(c))},
          {"returns", c.returns},
          {"losses", losses_json(c)},
          {"outages", c.outages},
          {"packets_lost_in_outages", c.lost_in_outages},
          {"wrong_model", c.wrong_model},
          {"stray_azimuths", c.stray_azimuths},
          {"uncalibrated_sweeps", c.uncalibrated_sweeps},
          {"two_sensors", c.two_sensors},
          {"out_of_order", c.out_of_order},
          {"clock_jumps", c.clock_jumps},
          {"clock", to_json(c.clock)}};
}

Json stream_json(const Device& device, const StreamCounters& c, Level level) {
  return {{"device", device.name},   {"kind", device.kind},    {"endpoint", device.endpoint},
          {"level", name_of(level)}, {"received", c.received}, {"used", c.used},
          {"refused", c.refused},    {"lost", c.lost},         {"out_of_order", c.out_of_order}};
}

Json odometry_json(const OdometryStatus& odometry) {
  Json json = {{"usable", odometry.usable()},
               {"wheel_scale", odometry.wheel_scale},
               {"wheel_scale_sigma", odometry.wheel_scale_sigma},
               {"yaw_rate_bias", odometry.yaw_rate_bias},
               {"yaw_rate_bias_sigma", odometry.yaw_rate_bias_sigma},
               {"sweeps_not_deskewed", odometry.not_deskewed}};
  if (!odometry.usable()) json["reason"] = odometry.reason;
  return json;
}

/// ", 3 malformed" for each cause that occurred.
std::string causes_text(const LidarCounters& c) {
  std::string text;
  const auto add = [&](uint64_t count, const char* cause) {
    if (count > 0) text += fmt::format(", {} {}", count, cause);
  };
  text += outages_text(c);
  add(c.lost_kernel, "of these in the kernel");
  add(c.malformed, "malformed");
  add(c.wrong_sender, "from an unexpected sender");
  add(c.duplicates, "duplicated");
  add(c.too_late, "too late");
  add(c.out_of_order, "reordered");
  add(c.wrong_model, "of another model");
  add(c.clock_jumps, "clock jumps");
  add(c.stray_azimuths, "stray azimuths");
  return text;
}

std::string clock_text(const ClockState& clock) {
  std::string text = describe(clock.source);
  if (clock.source != ClockState::Source::kNone && clock.source != ClockState::Source::kHost) {
    text += fmt::format("; host minus device {:.6f} s, {:+.1f} ppm, jitter {:.3f} ms",
                        to_seconds(clock.offset), clock.skew_ppm, to_seconds(clock.jitter) * 1e3);
  }
  if (!clock.trusted && *clock.reason != '\0')
    text += fmt::format("; not trusted: {}", clock.reason);
  return text;
}

std::string lidar_text(const Device& device, const LidarCounters& c, Level level) {
  std::string text = fmt::format("  {}: {}, {} ({})\n", device.name, device.model, name_of(level),
                                 device.model_reason);
  text += fmt::format("    {} packets ({:.1f}/s), {} lost{}\n", c.packets,
                      rate(c.packets, active_duration(c)), count_lost(c), causes_text(c));
  text += fmt::format(
      "    {} ({:.2f}/s), {} returns ({:.0f} per sweep)\n", counted(c.sweeps, "sweep"),
      sweep_rate(c), c.returns,
      c.sweeps == 0 ? 0.0 : static_cast<double>(c.returns) / static_cast<double>(c.sweeps));
  if (c.position_packets > 0) text += fmt::format("    {} position packets\n", c.position_packets);
  return text + "    clock: " + clock_text(c.clock) + "\n";
}

std::string stream_text(const Device& device, const StreamCounters& c, Level level) {
  std::string text = fmt::format("  {}: {} {}, {}\n    {} received ({:.1f}/s), {} used",
                                 device.name, device.kind, device.model, name_of(level), c.received,
                                 rate(c.received, c.last - c.first), c.used);
  if (c.refused > 0) text += fmt::format(", {} rejected", c.refused);
  if (c.lost > 0) text += fmt::format(", {} missing", c.lost);
  if (c.out_of_order > 0)
    text += fmt::format(", {} with a stamp before the previous one", c.out_of_order);
  return text + "\n";
}

}  // namespace

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

Summary summarise(const Replay& replay) {
  return {.path = replay.setup().path,
          .sensors = replay.totals().started ? replay.setup().sensors() : std::vector<Sensor>(),
          .totals = replay.totals(),
          .has_odometry = replay.totals().odometry.present,
          .notes = replay.notes()};
}

Json to_json(const Summary& summary) {
  Json json = {
      {"path", summary.path.string()},
      {"drive_s", rounded(drive_s(summary))},
      {"host_s", rounded(summary.host_s)},
      {"cpu_s", rounded(process_cpu_s())},
      {"realtime_factor", rounded(realtime_factor(summary))},
      {"peak_memory_mb", rounded(peak_memory_mb())},
      {"sweeps", sum_over_lidars(summary, [](auto& c) { return c.sweeps; })},
      {"returns", sum_over_lidars(summary, [](auto& c) { return c.returns; })},
      {"packets", sum_over_lidars(summary, [](auto& c) { return c.packets; })},
      {"packets_lost", sum_over_lidars(summary, [](auto& c) { return count_lost(c); })},
      {"position_packets", sum_over_lidars(summary, [](auto& c) { return c.position_packets; })},
      {"alerts", summary.totals.alerts},
      {"stopped", summary.stopped}};
  if (const StageStats* total = total_stage(summary)) {
    json["latency_ms"] = latency_ms_json(total->latency);
    json["deadline_misses"] = total->deadline_misses;
  }
  for (const StageStats& stage : summary.totals.host.stages) {
    json["stages"][stage.name] = latency_ms_json(stage.latency);
    json["stages"][stage.name]["count"] = stage.latency.count;
  }
  json["devices"] = Json::array();
  json["streams"] = Json::array();
  const Totals& totals = summary.totals;
  for (const auto& [id, device] : summary.sensors) {
    const Level level = level_of(id, totals.levels);
    if (id.kind == SensorKind::kLidar) {
      json["devices"].push_back(lidar_json(device, totals.counters.lidars.at(id.index), level));
    } else {
      json["streams"].push_back(stream_json(device, totals.counters.stream(id), level));
    }
  }
  if (summary.has_odometry) json["odometry"] = odometry_json(totals.odometry);
  json["calibrations"] = Json::array();
  for (const auto& [camera, report] : totals.calibrations) {
    json["calibrations"].push_back(calibration_json(report, totals.calibration_levels.at(camera)));
  }
  json["notes"] = Json::array();
  for (const Error& note : summary.notes) json["notes"].push_back(note.message());
  return json;
}

std::string sensor_text(const Sensor& sensor, const Totals& totals) {
  const auto& [id, device] = sensor;
  const Level level = level_of(id, totals.levels);
  if (id.kind != SensorKind::kLidar) return stream_text(device, totals.counters.stream(id), level);
  return lidar_text(device, totals.counters.lidars.at(id.index), level);
}

std::vector<LidarProblem> find_problems(const Summary& summary) {
  std::vector<LidarProblem> all;
  for (const auto& [id, device] : summary.sensors) {
    if (id.kind != SensorKind::kLidar) continue;
    const auto found = find_problems(device, summary.totals.counters.lidars.at(id.index));
    all.insert(all.end(), found.begin(), found.end());
  }
  return all;
}

std::string odometry_text(const OdometryStatus& odometry) {
  std::string text = "  odometry: ";
  text += odometry.usable() ? "trusted" : fmt::format("not trusted: {}", odometry.reason);
  for (const OdometrySourceStatus& source : odometry.sources) {
    if (source.accepted + source.rejected == 0) continue;
    text += fmt::format(", {}", source.name);
    if (source.rejected > 0) text += fmt::format(" ({} rejected)", source.rejected);
  }
  if (odometry.wheel_scale_sigma > 0) {  // there are wheels
    text += fmt::format("; wheel scale {:.4f} ± {:.4f}", odometry.wheel_scale,
                        odometry.wheel_scale_sigma);
  }
  text += fmt::format(", yaw-rate bias {:.3f} ± {:.3f} °/s\n", odometry.yaw_rate_bias / kDegree,
                      odometry.yaw_rate_bias_sigma / kDegree);
  if (odometry.not_deskewed > 0) {
    text += fmt::format("    {} not deskewed\n", counted(odometry.not_deskewed, "sweep"));
  }
  return text;
}

/// "deskew 1.20 ms p50, 2.00 ms p99, 3.10 ms max".
std::string stage_text(const StageStats& stage) {
  const LatencyStats& latency = stage.latency;
  return fmt::format("    {:<9} {:6.2f} ms p50, {:6.2f} ms p99, {:6.2f} ms max ({} times)\n",
                     stage.name, to_seconds(latency.p50) * 1e3, to_seconds(latency.p99) * 1e3,
                     to_seconds(latency.max) * 1e3, latency.count);
}

std::string to_text(const Summary& summary) {
  const Totals& totals = summary.totals;
  std::string text =
      fmt::format("{}: {:.1f} s of drive in {:.2f} s ({:.1f} × real time){}\n",
                  summary.path.string(), drive_s(summary), summary.host_s, realtime_factor(summary),
                  summary.stopped ? ", stopped early" : "");
  for (const Sensor& sensor : summary.sensors) text += sensor_text(sensor, totals);
  if (summary.has_odometry) text += odometry_text(totals.odometry);
  for (const auto& [camera, report] : totals.calibrations) {
    text += monitoring_text(report, totals.calibration_levels.at(camera));
  }
  if (const StageStats* total = total_stage(summary)) {
    text += "  latency of each stage\n";
    for (const StageStats& stage : totals.host.stages) {
      if (stage.latency.count > 0) text += stage_text(stage);
    }
    text += fmt::format("  {} of {}: report more than {:.0f} ms after the last data needed\n",
                        total->deadline_misses, counted(total->latency.count, "sweep"),
                        1e3 * to_seconds(FusionThread::kLatencyBudget));
  }
  text += fmt::format("  {}; {:.2f} s of processor time, {:.0f} MB peak memory\n",
                      counted(totals.alerts, "alert"), process_cpu_s(), peak_memory_mb());
  for (const AlertReport& alert : totals.first_alerts) {
    text +=
        fmt::format("  alert after {:.0f} s: {}: {} ({})\n", to_seconds(alert.stamp - totals.start),
                    alert.device, alert.finding.what, alert.finding.advice);
  }
  for (const LidarProblem& problem : find_problems(summary)) {
    text += "  problem: " + problem.what + "\n";
  }
  for (const Error& note : summary.notes) text += "  note: " + note.message() + "\n";
  return text;
}

}  // namespace infuse::daemon

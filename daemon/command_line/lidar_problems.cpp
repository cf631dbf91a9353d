#include "daemon/command_line/lidar_problems.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

#include "drivers/makers/makers.hpp"

namespace infuse::daemon {
namespace {

/// Collects the problems of one lidar.
class Problems {
 public:
  explicit Problems(const Device& device) : device_(device) {}

  void add(bool holds, Level level, const std::string& what) {
    if (holds) list_.push_back({level, device_.name + ": " + what});
  }

  /// Of the rate of turning, by the limits of the model; of an unknown one there is none.
  void add_turns(const lidar::LidarModel* model, double turns_hz) {
    if (model == nullptr) return;
    add(turns_hz < 0.9 * model->min_turns_hz || turns_hz > 1.05 * model->max_turns_hz, Level::kWarn,
        fmt::format("it turns {:.2f} times per second; a {} turns {} to {} times", turns_hz,
                    model->maker->name(), model->min_turns_hz, model->max_turns_hz));
  }

  std::vector<LidarProblem> list() && { return std::move(list_); }

 private:
  const Device& device_;
  std::vector<LidarProblem> list_;
};

/// Number of sweeps beyond those of the sensor's turns.
double excess_sweeps(const LidarCounters& c) {
  return static_cast<double>(c.sweeps) - c.turns_hz * to_seconds(active_duration(c));
}

}  // namespace

std::vector<LidarProblem> find_problems(const Device& device, const LidarCounters& c) {
  const lidar::LidarModel* model = makers::find_model(device.model);
  Problems problems(device);
  const bool turns = c.turns_hz > 0.1;
  problems.add(c.malformed > 0, c.malformed > c.packets ? Level::kError : Level::kWarn,
               fmt::format("{} datagrams are not packets of {}: {}", c.malformed, device.model,
                           c.malformed_reason));
  problems.add(
      c.wrong_model > 0, Level::kError,
      fmt::format("{} packets are another model's than {} ({}); give the right one with --model",
                  c.wrong_model, device.model, device.model_reason));
  problems.add(c.two_sensors, Level::kError,
               "packets of two sensors alternate from one address to one port: they cannot be told "
               "apart; give the sensors different ports");
  problems.add(
      c.uncalibrated_sweeps > 0, Level::kWarn,
      fmt::format(
          "{} of {} sweeps were decoded with the calibration of another unit, which is wrong "
          "by decimetres; give this unit's {} with --calibration",
          c.uncalibrated_sweeps, c.sweeps,
          model != nullptr ? model->maker->calibration_file() : "calibration"));
  if (turns) problems.add_turns(model, c.turns_hz);
  problems.add(!turns && c.turns_measured, Level::kWarn, "it does not turn");
  // A sweep more at either end, and as many as turns for a sensor that scans a part of the turn.
  problems.add(turns && excess_sweeps(c) > 3 + 0.5 * static_cast<double>(c.sweeps), Level::kError,
               fmt::format("{} sweeps in {:.1f} turns: its azimuth jumps", c.sweeps,
                           c.turns_hz * to_seconds(active_duration(c))));
  problems.add(c.lost_network > 0, Level::kWarn,
               fmt::format("{} packets lost{}", c.lost_network, outages_text(c)));
  problems.add(c.duplicates > c.packets / 100, Level::kWarn,
               fmt::format("{} packets came twice, and were used once: they were captured at two "
                           "points of the network, or two captures were joined",
                           c.duplicates));
  problems.add(c.stray_azimuths > 0, Level::kWarn,
               fmt::format("{} azimuths are impossible or out of line, and were interpolated",
                           c.stray_azimuths));
  problems.add(c.clock_jumps > 0, Level::kWarn,
               fmt::format("its clock jumps {} times", c.clock_jumps));
  return std::move(problems).list();
}

std::string outages_text(const LidarCounters& c) {
  if (c.outages == 0) return "";
  return fmt::format(
      ", {} of them in {} outage{} of a turn and longer",
      c.lost_in_outages == c.lost_network ? "all" : std::to_string(c.lost_in_outages), c.outages,
      c.outages == 1 ? "" : "s");
}

Level worst_level(Level level, const std::vector<LidarProblem>& problems) {
  for (const LidarProblem& problem : problems) level = std::max(level, problem.level);
  return level;
}

Duration active_duration(const LidarCounters& counters) {
  return counters.packets == 0 ? Duration::zero() : counters.last_packet - counters.first_packet;
}

double sweep_rate(const LidarCounters& counters) {
  if (counters.turns_measured) return counters.turns_hz;
  const double seconds = to_seconds(active_duration(counters));
  return seconds > 0 ? static_cast<double>(counters.sweeps) / seconds : 0;
}

}  // namespace infuse::daemon

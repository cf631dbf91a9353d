// Calibration monitoring on simulated drives: detection delay of a calibration fault, rate of false
// alarms. Baselines in the same run on the same drives: the online test of Levinson and Thrun, and
// mutual information of reflectivity and grey alone in the same sequential test.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>

#include "tests/bench/levinson_thrun.hpp"
#include "tests/bench/null_tail.hpp"
#include "tests/bench/online_loop.hpp"
#include "tests/bench/online_scenarios.hpp"

namespace infuse::online {
namespace {

using monitoring::Drift;
using monitoring::make_sweep_view;

/// Further drives for false alarms; recorded routes only if `./dev bench streetmap` has rendered
/// them.
const std::vector<std::string> kMoreScenarios = {
    "online_jam", "online_stop_and_go", "pedestrian_zone", "kitti_00", "kitti_05", "kitti_07"};

/// Number of other worlds along the same route, in every condition and in the jam.
constexpr int kWorldCount = 12;

/// Seconds from the fault to the suspected and the confirmed state; kNotDetected if not reached.
struct DetectionDelay {
  double suspected = kNotDetected, confirmed = kNotDetected;
};

/// Runs the monitor on a drive whose calibration becomes wrong.
DetectionDelay measure_delay(const Drive& drive, const Fault& fault,
                             const monitoring::MonitorOptions& options) {
  monitoring::CalibrationMonitor monitor(drive.intrinsics, drive.T_camera_lidar, options);
  DetectionDelay delay;
  for (size_t i = 0; i < drive.pairs.size(); ++i) {
    const ImageSweepPair& pair = drive.pairs[i];
    if (i == fault.first_pair)
      monitor.inject_miscalibration(geometry::exp(fault.perturbation) * drive.T_camera_lidar);
    const auto report =
        monitor.process(pair.grey, make_sweep_view(pair.sweep), {pair.angular_rate, pair.velocity});
    if (i < fault.first_pair) continue;
    const double after = to_seconds(pair.grey.stamp - drive.pairs[fault.first_pair].grey.stamp);
    if (report.verdict.drift == Drift::kSuspected)
      delay.suspected = std::min(delay.suspected, after);
    if (report.verdict.drift == Drift::kConfirmed) {
      delay.suspected = std::min(delay.suspected, after);
      delay.confirmed = after;
      break;
    }
  }
  return delay;
}

DetectionDelay measure_delay_levinson_thrun(const Drive& drive, const Fault& fault) {
  LevinsonThrun test(drive.intrinsics, drive.T_camera_lidar);
  for (size_t i = 0; i < drive.pairs.size(); ++i) {
    const ImageSweepPair& pair = drive.pairs[i];
    if (i == fault.first_pair)
      test.set_calibration(geometry::exp(fault.perturbation) * drive.T_camera_lidar);
    if (!test.process(pair.grey, make_sweep_view(pair.sweep)) || i < fault.first_pair) continue;
    const double after = to_seconds(pair.grey.stamp - drive.pairs[fault.first_pair].grey.stamp);
    return {after, after};
  }
  return {};
}

enum class Method { kMonitor, kMutualInformation, kLevinsonThrun };

monitoring::MonitorOptions options_for(Method method) {
  monitoring::MonitorOptions options;
  if (method == Method::kMutualInformation) options.weights = {.reflectivity = 1, .edges = 0};
  return options;
}

/// Median time to confirmation in seconds; counters give suspicion, the 98th percentile, and the
/// percentage detected within `within` seconds. `faults`: number of seeds, distributed over the
/// conditions.
void detect(benchmark::State& state, const std::vector<int>& axes, size_t faults, double within,
            Method method) {
  std::vector<double> suspected, confirmed;
  for (auto _ : state) {
    for (size_t seed = 0; seed < faults; ++seed) {
      const Drive& drive = load_drive(kScenarios[seed % kScenarios.size()]);
      const Fault fault = random_fault(seed, axes, 90);
      const DetectionDelay delay = method == Method::kLevinsonThrun
                                       ? measure_delay_levinson_thrun(drive, fault)
                                       : measure_delay(drive, fault, options_for(method));
      suspected.push_back(delay.suspected);
      confirmed.push_back(delay.confirmed);
    }
    state.SetIterationTime(std::min(quantile(confirmed, 0.5), 600.0));
  }
  const auto found =
      std::count_if(confirmed.begin(), confirmed.end(), [&](double s) { return s <= within; });
  state.counters["faults"] = static_cast<double>(faults);
  state.counters["detected_percent"] =
      100.0 * static_cast<double>(found) / static_cast<double>(confirmed.size());
  state.counters["suspected_p98_s"] = std::min(quantile(suspected, 0.98), 600.0);
  state.counters["confirmed_p98_s"] = std::min(quantile(confirmed, 0.98), 600.0);
  state.SetLabel("to confirmation, median");
}

/// Runs one drive without a fault; returns its hours, counts alarms, adds the evidence of its
/// evaluations.
double run_without_fault(const std::filesystem::path& drive, Method method, int& alarms,
                         NullTail& tail) {
  std::optional<monitoring::CalibrationMonitor> monitor;
  std::optional<LevinsonThrun> levinson;
  Stamp first, last;
  bool raised = false;
  for_each_pair(drive, [&](const Truth& truth, ImageSweepPair& pair) {
    last = pair.grey.stamp;
    if (!monitor) {
      monitor.emplace(truth.intrinsics, truth.T_camera_lidar, options_for(method));
      levinson.emplace(truth.intrinsics, truth.T_camera_lidar);
      first = last;
    }
    bool alarm = false;
    if (method == Method::kLevinsonThrun) {
      alarm = levinson->process(pair.grey, make_sweep_view(pair.sweep));
    } else {
      const auto report = monitor->process(pair.grey, make_sweep_view(pair.sweep),
                                           {pair.angular_rate, pair.velocity});
      alarm = report.verdict.drift == Drift::kConfirmed;
      if (report.evaluated) tail.add(report.verdict.evidence);
    }
    alarms += alarm && !raised ? 1 : 0;
    raised = alarm;
  });
  tail.end_excursion();
  return to_seconds(last - first) / 3600;
}

/// Drives of `false_alarms`.
std::vector<std::filesystem::path> drives_without_fault(Method method) {
  std::vector<std::filesystem::path> drives;
  for (const std::string& name : kScenarios) drives.push_back(rendered_drive(name));
  if (method == Method::kLevinsonThrun) return drives;  // a grid of 728 poses is slow
  for (const std::filesystem::path& large : large_drives()) drives.push_back(large);
  for (const std::string& name : kMoreScenarios) {
    if (name.starts_with("kitti") && !std::filesystem::exists(bench_drives_folder() / name))
      continue;
    drives.push_back(rendered_drive(name));
  }
  std::vector<std::string> repeated = kScenarios;
  repeated.emplace_back("online_jam");
  for (int seed = 101; seed < 101 + kWorldCount; ++seed) {
    const std::string number = std::to_string(seed);
    for (const std::string& name : repeated) {
      drives.push_back(rendered_drive(name, name + "_" + number, " --seed " + number));
    }
  }
  return drives;
}

/// Drive hours per false alarm in all conditions (one alarm counted if there was none); for the
/// monitor also the time between alarms from the tail of its evidence.
void false_alarms(benchmark::State& state, Method method) {
  double hours = 0;
  int alarms = 0;
  NullTail tail;
  for (auto _ : state) {
    for (const std::filesystem::path& drive : drives_without_fault(method)) {
      const double driven = run_without_fault(drive, method, alarms, tail);
      std::fprintf(stderr, "%s: %.1f min, %d alarms so far, %zu peaks\n", drive.filename().c_str(),
                   60 * driven, alarms, tail.peak_count());
      hours += driven;
    }
    state.SetIterationTime(1);
  }
  state.counters["items_per_second"] = hours / std::max(1, alarms);
  state.counters["false_alarms"] = alarms;
  state.counters["drive_hours"] = hours;
  if (method != Method::kLevinsonThrun) {
    const double limit = monitoring::DriftDetectorOptions{}.confirmation_threshold();
    state.counters["peaks"] = static_cast<double>(tail.peak_count());
    state.counters["peak_scale_nats"] = tail.excess_scale();
    state.counters["hours_between_alarms"] =
        tail.hours_between_alarms(limit, hours, tail.excess_scale());
    state.counters["hours_between_alarms_95"] =
        tail.hours_between_alarms(limit, hours, tail.upper_excess_scale());
    for (size_t nats = 1; nats < 8; ++nats) {
      std::fprintf(stderr, "%zu nats or more: %.4f of evaluations\n", nats,
                   tail.fraction_above(nats));
    }
  }
  state.SetLabel("drive hours per alarm");
}

struct FaultKind {
  const char* name;
  std::vector<int> axes;
  size_t faults;
  double within;
};

int register_benchmarks() {
  const std::vector<FaultKind> kinds = {{"online/detect/rotation_0.5_deg", {0, 1, 2}, 100, 20},
                                        {"online/detect/translation_xy_5_cm", {3, 4}, 60, 60}};
  const std::vector<std::pair<std::string, Method>> methods = {
      {"", Method::kMonitor},
      {"/baseline:mutual-information", Method::kMutualInformation},
      {"/baseline:levinson-thrun", Method::kLevinsonThrun}};
  for (const auto& [suffix, method] : methods) {
    for (const FaultKind& kind : kinds) {
      // The grid of 728 poses is slow: use a quarter of the faults.
      const size_t faults = method == Method::kLevinsonThrun ? kind.faults / 4 : kind.faults;
      register_run(kind.name + suffix, [kind, faults, method = method](benchmark::State& state) {
        detect(state, kind.axes, faults, kind.within, method);
      });
    }
    register_run("online/false_alarms" + suffix,
                 [method = method](benchmark::State& state) { false_alarms(state, method); });
  }
  return 0;
}

const int kRegistered = register_benchmarks();

}  // namespace
}  // namespace infuse::online

// Calibration monitoring on simulated drives: detection delay of a calibration fault, rate of false
// alarms, accuracy of the re-estimation, cost of an evaluation. Baselines in the same run on the
// same drives: the online test of Levinson and Thrun, and mutual information of reflectivity and
// grey alone in the same sequential test.
//
// Drives are rendered once (`rendered_drive.hpp`).

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>

#include "drivers/measurement/angles.hpp"
#include "tests/bench/levinson_thrun.hpp"
#include "tests/bench/null_tail.hpp"
#include "tests/bench/online_loop.hpp"
#include "tests/bench/rendered_drive.hpp"
#include "tests/fusion/monitoring/kitti_stream.hpp"

namespace infuse::online {
namespace {

using monitoring::Drift;
using monitoring::make_sweep_view;

constexpr double kNotDetected = 1e9;

const Drive& load_drive(const std::string& scenario) {
  static std::map<std::string, std::unique_ptr<Drive>> drives;
  std::unique_ptr<Drive>& drive = drives[scenario];
  if (drive) return *drive;
  drive = std::make_unique<Drive>(read_drive(rendered_drive(scenario)));
  return *drive;
}

/// Drives of 90 s of one rig: kept in memory.
const std::vector<std::string> kScenarios = {"online_2hz", "online_overcast", "online_low_sun",
                                             "online_dusk"};
/// Further drives for false alarms; recorded routes only if `./dev bench streetmap` has rendered
/// them.
const std::vector<std::string> kMoreScenarios = {
    "online_jam", "online_stop_and_go", "pedestrian_zone", "kitti_00", "kitti_05", "kitti_07"};

/// A lidar with 64 beams and a camera of 1.3 megapixels; only one such drive is kept in memory.
const std::vector<std::string> kLargeScenarios = {"online_large", "online_large_low_sun"};

/// Seed of the second world of a large drive.
const std::string kSecondWorldSeed = "101";

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

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<size_t>(share * static_cast<double>(values.size())))];
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

/// Large drives, each in two worlds.
std::vector<std::filesystem::path> large_drives() {
  std::vector<std::filesystem::path> drives;
  for (const std::string& name : kLargeScenarios) {
    drives.push_back(rendered_drive(name));
    drives.push_back(
        rendered_drive(name, name + "_" + kSecondWorldSeed, " --seed " + kSecondWorldSeed));
  }
  return drives;
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

/// Accumulated angle of a drift of 0.05° per minute when it is suspected and when it is confirmed:
/// the worst of three axes and both signs.
void slow_drift(benchmark::State& state) {
  double suspected = 0, confirmed = 0;
  for (auto _ : state) {
    std::vector<const Drive*> drives;
    for (int round = 0; round < 2; ++round) {
      for (const std::string& name : kScenarios) drives.push_back(&load_drive(name));
    }
    for (int axis = 0; axis < 3; ++axis) {
      for (const double rate : {0.05, -0.05}) {
        const DriftAngles detected = detect_slow_drift(drives, axis, rate);
        std::fprintf(stderr,
                     "axis %d, %+.2f degrees a minute: suspected at %.3f, confirmed at %.3f\n",
                     axis, rate, detected.suspected_deg, detected.confirmed_deg);
        suspected = std::max(suspected, detected.suspected_deg);
        confirmed = std::max(confirmed, detected.confirmed_deg);
      }
    }
    state.SetIterationTime(1);
  }
  state.counters["suspected_worst_deg"] = std::min(suspected, 9.0);
  state.counters["confirmed_worst_deg"] = std::min(confirmed, 9.0);
}

/// Knocks about or along every axis in every condition, `size` in degrees or cm, in both
/// directions: time to suspicion and confirmation, and how many are named with their axis and have
/// an amount within three stated standard deviations.
void knocks(benchmark::State& state, const std::vector<int>& axes, double size) {
  std::vector<double> suspected, confirmed;
  double named = 0, covered = 0;
  for (auto _ : state) {
    for (size_t k = 0; k < kScenarios.size() * axes.size() * 2; ++k) {
      const Drive& drive = load_drive(kScenarios[k % kScenarios.size()]);
      const int axis = axes[k / kScenarios.size() / 2];
      const double sign = k / kScenarios.size() % 2 == 0 ? 1 : -1;
      const double amount = sign * size * (axis < 3 ? kDegree : 0.01);
      const Fault fault{amount * Vector6::Unit(axis), 30 + 7 * k % 60};
      const KnockResult found = run_knock(drive, fault);
      const auto& verdict = found.verdict;
      suspected.push_back(found.suspected);
      confirmed.push_back(found.confirmed);
      const bool right = verdict.axis == static_cast<monitoring::Axis>(axis);
      const bool inside = std::abs(verdict.offset(axis) - amount) <= 3 * verdict.sigma(axis);
      named += right ? 1 : 0;
      covered += inside ? 1 : 0;
      if (right && inside && found.confirmed < kNotDetected) continue;
      std::fprintf(stderr,
                   "%s, pair %zu, axis %d by %+.1f: suspected %.1f s, confirmed %.1f s: %s\n",
                   kScenarios[k % kScenarios.size()].c_str(), fault.first_pair, axis, sign * size,
                   found.suspected, found.confirmed, describe_drift(verdict).c_str());
    }
    state.SetIterationTime(std::min(quantile(confirmed, 0.5), 600.0));
  }
  const auto all = static_cast<double>(confirmed.size());
  state.counters["suspected_median_s"] = std::min(quantile(suspected, 0.5), 600.0);
  state.counters["suspected_p95_s"] = std::min(quantile(suspected, 0.95), 600.0);
  state.counters["confirmed_p95_s"] = std::min(quantile(confirmed, 0.95), 600.0);
  state.counters["named_percent"] = 100 * named / all;
  state.counters["covered_percent"] = 100 * covered / all;
  state.SetLabel("to confirmation, median");
}

/// Stamps that become late or early by `delay` s: how often they are suspected, and how often named
/// as late stamps or as the axis that this motion cannot tell from them.
void late_stamps(benchmark::State& state, double delay) {
  double suspected = 0, confirmed = 0, named = 0, all = 0;
  for (auto _ : state) {
    for (size_t k = 0; k < 4 * kScenarios.size(); ++k) {
      const Fault fault{Vector6::Zero(), 30 + 7 * k % 60};
      const double late = k / kScenarios.size() % 2 == 0 ? delay : -delay;
      const KnockResult found =
          run_knock(load_drive(kScenarios[k % kScenarios.size()]), fault, late);
      const auto& verdict = found.verdict;
      const bool seen = found.suspected < kNotDetected;
      const bool right =
          verdict.axis == monitoring::Axis::kTime || verdict.delay_ambiguous_axis == verdict.axis;
      ++all;
      suspected += seen ? 1 : 0;
      confirmed += found.confirmed < kNotDetected ? 1 : 0;
      named += seen && right ? 1 : 0;
      std::fprintf(stderr, "%+.0f ms: suspected %.1f s, confirmed %.1f s: %s\n", 1e3 * late,
                   found.suspected, found.confirmed, describe_drift(verdict).c_str());
    }
    state.SetIterationTime(1);
  }
  state.counters["faults"] = all;
  state.counters["suspected"] = suspected;
  state.counters["confirmed"] = confirmed;
  state.counters["named"] = named;
}

/// Complete loop (`run_recovery`) over the large drives, by seeds: rotation and translation error
/// of the calibration in use at the end, normalised squared error per degree of freedom.
void recalibrate(benchmark::State& state, size_t faults) {
  std::vector<double> degrees, across, along, normalised, seconds, after;
  const auto run = [&](const Drive& drive, const std::string& name, uint64_t seed) {
    const RecoveryResult recovery = run_recovery(drive, random_fault(seed, {0, 1, 2, 3, 4}, 75));
    seconds.insert(seconds.end(), recovery.cpu_seconds.begin(), recovery.cpu_seconds.end());
    const Vector6& e = recovery.error;
    std::fprintf(stderr,
                 "%s seed %zu: %s, alarm after %.1f s, in use %.1f s later; %.3f %.3f %.3f deg, "
                 "%.1f %.1f %.1f cm, normalised %.2f\n",
                 name.c_str(), seed, recovery.applied ? "applied" : "not applied",
                 recovery.alarm_delay, recovery.apply_delay, e(0) / kDegree, e(1) / kDegree,
                 e(2) / kDegree, 100 * e(3), 100 * e(4), 100 * e(5), recovery.normalised_error);
    if (!recovery.applied) return;
    degrees.push_back(e.head<3>().norm() / kDegree);
    across.push_back(e.segment<2>(3).norm());
    along.push_back(std::abs(e(5)));
    normalised.push_back(recovery.normalised_error);
    after.push_back(recovery.apply_delay);
  };
  for (auto _ : state) {
    const auto drives = large_drives();
    uint64_t seed = 100;
    for (size_t i = 0; i < drives.size(); ++i) {
      const Drive drive = read_drive(drives[i]);
      for (; seed < 100 + faults * (i + 1) / drives.size(); ++seed) {
        run(drive, drives[i].filename(), seed);
      }
    }
    state.SetIterationTime(seconds.empty() ? 600 : quantile(seconds, 0.5));
  }
  if (degrees.empty()) return;
  const auto n = static_cast<double>(normalised.size());
  double sum = 0, inside = 0;
  for (const double one : normalised) {
    sum += one;
    inside += 6 * one < 12.59 ? 1 : 0;  // χ² of 6 degrees, 95 %
  }
  state.counters["applied_percent"] = 100 * n / static_cast<double>(faults);
  state.counters["rotation_deg"] = quantile(degrees, 0.5);
  state.counters["rotation_p90_deg"] = quantile(degrees, 0.9);
  state.counters["rotation_worst_deg"] = quantile(degrees, 1);
  state.counters["across_m"] = quantile(across, 0.5);
  state.counters["across_p90_m"] = quantile(across, 0.9);
  state.counters["across_worst_m"] = quantile(across, 1);
  state.counters["along_worst_m"] = quantile(along, 1);
  state.counters["normalised_error"] = sum / n;
  state.counters["inside_95_percent"] = 100 * inside / n;
  state.counters["after_alarm_worst_s"] = quantile(after, 1);
}

/// KITTI pairs as a stream, with extrinsics wrong by 0.5°, 1° and 2° about each axis in both
/// directions: number of detections, error of the re-estimation against the published extrinsics,
/// and evidence with the published ones.
void kitti_stream(benchmark::State& state) {
  const char* data = std::getenv("INFUSE_REAL_DATA");
  const auto stream = monitoring::kitti::read_stream(
      std::filesystem::path(data == nullptr ? "" : data) / "calibration/kitti");
  if (stream.images.empty()) return state.SkipWithError("INFUSE_REAL_DATA has no KITTI pairs");
  std::vector<double> degrees, metres;
  double detected = 0, confirmed = 0, usable = 0, all = 0, evidence = 0;
  for (auto _ : state) {
    monitoring::CalibrationMonitor right(stream.camera, stream.T_camera_lidar, {});
    evidence = monitoring::kitti::drive(right, stream, 4).verdict.evidence;
    for (const double size : {0.5, -0.5, 1.0, -1.0, 2.0, -2.0}) {
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Isometry3d wrong =
            geometry::exp(size * kDegree * Vector6::Unit(axis)) * stream.T_camera_lidar;
        monitoring::CalibrationMonitor monitor(stream.camera, wrong, {});
        const Drift drift = monitoring::kitti::drive(monitor, stream, 4).verdict.drift;
        detected += drift == Drift::kSuspected || drift == Drift::kConfirmed ? 1 : 0;
        confirmed += drift == Drift::kConfirmed ? 1 : 0;
        const monitoring::Reestimate found = monitoring::kitti::estimate(stream, wrong);
        const Vector6 error = geometry::log(found.T_camera_lidar * stream.T_camera_lidar.inverse());
        std::fprintf(stderr, "%+.1f degrees about axis %d: %.3f deg, %.1f cm %s\n", size, axis,
                     error.head<3>().norm() / kDegree, 100 * error.tail<3>().norm(),
                     found.reason.c_str());
        ++all;
        if (!found.usable()) continue;
        ++usable;
        degrees.push_back(error.head<3>().norm() / kDegree);
        metres.push_back(error.tail<3>().norm());
      }
    }
    state.SetIterationTime(1);
  }
  state.counters["faults"] = all;
  state.counters["detected"] = detected;
  state.counters["confirmed"] = confirmed;
  state.counters["usable"] = usable;
  state.counters["evidence_unperturbed"] = evidence;
  if (degrees.empty()) return;
  state.counters["rotation_worst_deg"] = quantile(degrees, 1);
  state.counters["translation_worst_m"] = quantile(metres, 1);
}

/// Processor time of a re-estimation from 30 scenes of 1.3 megapixels.
void reestimate(benchmark::State& state) {
  const Drive drive = read_drive(large_drives().front());
  monitoring::CalibrationMonitor monitor(drive.intrinsics, drive.T_camera_lidar, {});
  for (const ImageSweepPair& pair : drive.pairs) {
    if (monitor.scenes().size() == 30) break;
    monitor.process(pair.grey, make_sweep_view(pair.sweep), {pair.angular_rate, pair.velocity});
  }
  const auto scenes = monitor.scenes().lend(Stamp::earliest());
  const Eigen::Isometry3d wrong =
      geometry::exp(kHalfDegree * Vector6::Unit(1)) * drive.T_camera_lidar;
  for (auto _ : state) {
    benchmark::DoNotOptimize(monitoring::reestimate(scenes, drive.intrinsics, wrong, {}));
  }
  state.counters["scenes"] = static_cast<double>(scenes.size());
}

/// Processor time of an evaluation of a 1.3 megapixel image and a sweep of 64 beams.
void evaluate_pair(benchmark::State& state) {
  std::optional<ImageSweepPair> pair;
  std::optional<monitoring::CalibrationMonitor> monitor;
  int seen = 0;
  for_each_pair(large_drives().front(), [&](const Truth& truth, ImageSweepPair& next) {
    if (++seen != 40) return;  // a pair in the middle
    pair = std::move(next);
    monitor.emplace(truth.intrinsics, truth.T_camera_lidar, monitoring::MonitorOptions{});
  });
  if (!pair) return state.SkipWithError("no drive");
  int64_t next = 0;
  for (auto _ : state) {
    pair->grey.stamp = Stamp::from_ns(500'000'000 * ++next);
    pair->grey.pixels[static_cast<size_t>(next) % 1000] ^= 1;
    benchmark::DoNotOptimize(monitor->process(pair->grey, make_sweep_view(pair->sweep),
                                              {.velocity = Eigen::Vector3d(0, 0, 9)}));
  }
  state.counters["returns"] = static_cast<double>(pair->sweep.size());
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
  const auto add = [](const std::string& name, const auto& run) {
    return benchmark::RegisterBenchmark(name.c_str(), run)
        ->UseManualTime()
        ->Iterations(1)
        ->Unit(benchmark::kSecond);
  };
  for (const double degrees : {0.5, 1.0, 2.0, 3.0, 5.0}) {
    char name[48];
    std::snprintf(name, sizeof name, "online/knocks/%.1f_deg", degrees);
    add(name, [=](benchmark::State& state) { knocks(state, {0, 1, 2}, degrees); });
  }
  for (const double ms : {20.0, 50.0, 100.0}) {
    char name[48];
    std::snprintf(name, sizeof name, "online/late_stamps/%.0f_ms", ms);
    add(name, [=](benchmark::State& state) { late_stamps(state, 1e-3 * ms); });
  }
  for (const double cm : {10.0, 20.0}) {
    char name[48];
    std::snprintf(name, sizeof name, "online/knocks/%.0f_cm", cm);
    add(name, [=](benchmark::State& state) { knocks(state, {3, 4, 5}, cm); });
  }
  for (const auto& [suffix, method] : methods) {
    for (const FaultKind& kind : kinds) {
      // The grid of 728 poses is slow: use a quarter of the faults.
      const size_t faults = method == Method::kLevinsonThrun ? kind.faults / 4 : kind.faults;
      add(kind.name + suffix, [kind, faults, method = method](benchmark::State& state) {
        detect(state, kind.axes, faults, kind.within, method);
      });
    }
    add("online/false_alarms" + suffix,
        [method = method](benchmark::State& state) { false_alarms(state, method); });
  }
  add("online/slow_drift", slow_drift);
  add("online/recalibrate", [](benchmark::State& state) { recalibrate(state, 50); });
  add("online/kitti", kitti_stream);
  benchmark::RegisterBenchmark("online/reestimate", reestimate)->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("online/evaluation", evaluate_pair)->Unit(benchmark::kMillisecond);
  return 0;
}

const int kRegistered = register_benchmarks();

}  // namespace
}  // namespace infuse::online

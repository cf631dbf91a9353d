// The online watch on simulated drives: how soon a fault of the calibration is noticed, how often
// there is a false alarm, what re-estimation reaches, what a look costs. Baselines in the same run
// on the same drives: the online test of Levinson and Thrun, and mutual information of reflectivity
// and grey alone in the same sequential test.
//
// Drives are rendered once (`rendered_drive.hpp`).

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>

#include "tests/bench/levinson_thrun.hpp"
#include "tests/bench/null_tail.hpp"
#include "tests/bench/online_loop.hpp"
#include "tests/bench/rendered_drive.hpp"
#include "tests/fusion/watch/kitti_stream.hpp"

namespace infuse::online {
namespace {

using watch::Drift;
using watch::view_of;

constexpr double kNever = 1e9;

const Drive& drive_of(const std::string& scenario) {
  static std::map<std::string, std::unique_ptr<Drive>> drives;
  std::unique_ptr<Drive>& drive = drives[scenario];
  if (drive) return *drive;
  drive = std::make_unique<Drive>(read_drive(rendered_drive(scenario)));
  return *drive;
}

/// Of 90 s each, of one rig: kept in memory.
const std::vector<std::string> kConditions = {"online_2hz", "online_overcast", "online_low_sun",
                                              "online_dusk"};
/// Beside them for false alarms; those of recorded routes only where `./dev bench streetmap` has
/// rendered them.
const std::vector<std::string> kMore = {"online_jam", "online_stop_and_go", "pedestrian_zone",
                                        "kitti_00",   "kitti_05",           "kitti_07"};

/// A lidar of 64 beams and 1.3 megapixels; of these one drive at a time is kept.
const std::vector<std::string> kLarge = {"online_large", "online_large_low_sun"};

/// The second world of a large drive.
const std::string kSecondWorld = "101";

/// And so many other worlds along the same route, in every condition and in the jam.
constexpr int kWorlds = 12;

/// Seconds from the fault to suspicion and to certainty; kNever where there is none.
struct Delay {
  double suspect = kNever, certain = kNever;
};

/// The watch; its calibration becomes wrong without its being told.
Delay notice(const Drive& drive, const Fault& fault, const watch::WatchOptions& options) {
  watch::Watch watch(drive.intrinsics, drive.T_camera_lidar, options);
  Delay delay;
  for (size_t i = 0; i < drive.pairs.size(); ++i) {
    const Pair& pair = drive.pairs[i];
    if (i == fault.from) watch.misplace(geometry::exp(fault.off) * drive.T_camera_lidar);
    const auto report =
        watch.take(pair.grey, view_of(pair.sweep), {pair.angular_rate, pair.velocity});
    if (i < fault.from) continue;
    const double after = to_seconds(pair.grey.stamp - drive.pairs[fault.from].grey.stamp);
    if (report.drift == Drift::kSuspect) delay.suspect = std::min(delay.suspect, after);
    if (report.drift == Drift::kDrifted) {
      delay.suspect = std::min(delay.suspect, after);
      delay.certain = after;
      break;
    }
  }
  return delay;
}

Delay notice_levinson(const Drive& drive, const Fault& fault) {
  LevinsonThrun test(drive.intrinsics, drive.T_camera_lidar);
  for (size_t i = 0; i < drive.pairs.size(); ++i) {
    const Pair& pair = drive.pairs[i];
    if (i == fault.from) test.set_calibration(geometry::exp(fault.off) * drive.T_camera_lidar);
    if (!test.take(pair.grey, view_of(pair.sweep)) || i < fault.from) continue;
    const double after = to_seconds(pair.grey.stamp - drive.pairs[fault.from].grey.stamp);
    return {after, after};
  }
  return {};
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<size_t>(share * static_cast<double>(values.size())))];
}

enum class Who { kWatch, kInformation, kLevinson };

watch::WatchOptions options_of(Who who) {
  watch::WatchOptions options;
  if (who == Who::kInformation) options.weights = {.reflectivity = 1, .edges = 0};
  return options;
}

/// Seconds to certainty: the median, and beside it in a table suspicion, the 98th percentile, and
/// how many were found in `within` seconds. `faults`: of the first seeds, dealt out to the
/// conditions.
void detect(benchmark::State& state, const std::vector<int>& axes, size_t faults, double within,
            Who who) {
  std::vector<double> suspect, certain;
  for (auto _ : state) {
    for (size_t seed = 0; seed < faults; ++seed) {
      const Drive& drive = drive_of(kConditions[seed % kConditions.size()]);
      const Fault fault = fault_of(seed, axes, 90);
      const Delay delay = who == Who::kLevinson ? notice_levinson(drive, fault)
                                                : notice(drive, fault, options_of(who));
      suspect.push_back(delay.suspect);
      certain.push_back(delay.certain);
    }
    state.SetIterationTime(std::min(quantile(certain, 0.5), 600.0));
  }
  const auto found =
      std::count_if(certain.begin(), certain.end(), [&](double s) { return s <= within; });
  state.counters["faults"] = static_cast<double>(faults);
  state.counters["found_percent"] =
      100.0 * static_cast<double>(found) / static_cast<double>(certain.size());
  state.counters["suspect_p98_s"] = std::min(quantile(suspect, 0.98), 600.0);
  state.counters["drifted_p98_s"] = std::min(quantile(certain, 0.98), 600.0);
  state.SetLabel("to certainty, median");
}

/// One drive without a fault; gives back its hours, counts alarms, adds the evidence of its looks.
double drive_without_fault(const std::filesystem::path& drive, Who who, int& alarms,
                           NullTail& tail) {
  std::optional<watch::Watch> watch;
  std::optional<LevinsonThrun> levinson;
  Stamp first, last;
  bool raised = false;
  for_each_pair(drive, [&](const Truth& truth, Pair& pair) {
    last = pair.grey.stamp;
    if (!watch) {
      watch.emplace(truth.intrinsics, truth.T_camera_lidar, options_of(who));
      levinson.emplace(truth.intrinsics, truth.T_camera_lidar);
      first = last;
    }
    bool alarm = false;
    if (who == Who::kLevinson) {
      alarm = levinson->take(pair.grey, view_of(pair.sweep));
    } else {
      const auto report =
          watch->take(pair.grey, view_of(pair.sweep), {pair.angular_rate, pair.velocity});
      alarm = report.drift == Drift::kDrifted;
      if (report.looked) tail.add(report.evidence);
    }
    alarms += alarm && !raised ? 1 : 0;
    raised = alarm;
  });
  tail.end_excursion();
  return to_seconds(last - first) / 3600;
}

/// The large drives, each in two worlds.
std::vector<std::filesystem::path> large_drives() {
  std::vector<std::filesystem::path> drives;
  for (const std::string& name : kLarge) {
    drives.push_back(rendered_drive(name));
    drives.push_back(rendered_drive(name, name + "_" + kSecondWorld, " --seed " + kSecondWorld));
  }
  return drives;
}

/// The drives of `false_alarms`.
std::vector<std::filesystem::path> drives_without_fault(Who who) {
  std::vector<std::filesystem::path> drives;
  for (const std::string& name : kConditions) drives.push_back(rendered_drive(name));
  if (who == Who::kLevinson) return drives;  // a grid of 728 poses takes long
  for (const std::filesystem::path& large : large_drives()) drives.push_back(large);
  for (const std::string& name : kMore) {
    if (name.starts_with("kitti") && !std::filesystem::exists(bench_drives() / name)) continue;
    drives.push_back(rendered_drive(name));
  }
  std::vector<std::string> again = kConditions;
  again.emplace_back("online_jam");
  for (int seed = 101; seed < 101 + kWorlds; ++seed) {
    const std::string number = std::to_string(seed);
    for (const std::string& name : again) {
      drives.push_back(rendered_drive(name, name + "_" + number, " --seed " + number));
    }
  }
  return drives;
}

/// Looks without an alarm, in all conditions, as drive hours a false alarm (one counted where there
/// was none); for the watch, what the tail of its evidence says of the time between alarms.
void false_alarms(benchmark::State& state, Who who) {
  double hours = 0;
  int alarms = 0;
  NullTail tail;
  for (auto _ : state) {
    for (const std::filesystem::path& drive : drives_without_fault(who)) {
      const double driven = drive_without_fault(drive, who, alarms, tail);
      std::fprintf(stderr, "%s: %.1f min, %d alarms so far, %zu peaks\n", drive.filename().c_str(),
                   60 * driven, alarms, tail.peaks());
      hours += driven;
    }
    state.SetIterationTime(1);
  }
  state.counters["items_per_second"] = hours / std::max(1, alarms);
  state.counters["false_alarms"] = alarms;
  state.counters["drive_hours"] = hours;
  if (who != Who::kLevinson) {
    const double limit = watch::DriftTestOptions{}.certain();
    state.counters["peaks"] = static_cast<double>(tail.peaks());
    state.counters["peak_scale_nats"] = tail.scale();
    state.counters["hours_between"] = tail.hours_between(limit, hours, tail.scale());
    state.counters["hours_between_95"] = tail.hours_between(limit, hours, tail.upper_scale());
    for (size_t nats = 1; nats < 8; ++nats) {
      std::fprintf(stderr, "%zu nats or more: %.4f of looks\n", nats, tail.share(nats));
    }
  }
  state.SetLabel("h of drive an alarm");
}

/// Degrees that a drift of 0.05° a minute has built up when it is suspected: the worst of three
/// axes and both signs, and when it is certain.
void slow_drift(benchmark::State& state) {
  double suspect = 0, certain = 0;
  for (auto _ : state) {
    std::vector<const Drive*> drives;
    for (int round = 0; round < 2; ++round) {
      for (const std::string& name : kConditions) drives.push_back(&drive_of(name));
    }
    for (int axis = 0; axis < 3; ++axis) {
      for (const double rate : {0.05, -0.05}) {
        const Noticed noticed = notice_slow(drives, axis, rate);
        std::fprintf(stderr,
                     "axis %d, %+.2f degrees a minute: suspected at %.3f, certain at %.3f\n", axis,
                     rate, noticed.suspect, noticed.certain);
        suspect = std::max(suspect, noticed.suspect);
        certain = std::max(certain, noticed.certain);
      }
    }
    state.SetIterationTime(1);
  }
  state.counters["suspect_worst_deg"] = std::min(suspect, 9.0);
  state.counters["certain_worst_deg"] = std::min(certain, 9.0);
}

/// The whole loop (`mend`), by seeds over the large drives: rotation and translation error of what
/// is in use at the end, normalised squared error a degree of freedom.
void recalibrate(benchmark::State& state, size_t faults) {
  std::vector<double> degrees, across, along, normalised, seconds, after;
  const auto run = [&](const Drive& drive, const std::string& name, uint64_t seed) {
    const Mended mended = mend(drive, fault_of(seed, {0, 1, 2, 3, 4}, 75));
    seconds.insert(seconds.end(), mended.cpu.begin(), mended.cpu.end());
    const Vector6& e = mended.error;
    std::fprintf(stderr,
                 "%s seed %zu: %s, alarm after %.1f s, in use %.1f s later; %.3f %.3f %.3f deg, "
                 "%.1f %.1f %.1f cm, normalised %.2f\n",
                 name.c_str(), seed, mended.applied ? "applied" : "not applied", mended.alarm,
                 mended.after, e(0) * 180 / M_PI, e(1) * 180 / M_PI, e(2) * 180 / M_PI, 100 * e(3),
                 100 * e(4), 100 * e(5), mended.normalised);
    if (!mended.applied) return;
    degrees.push_back(e.head<3>().norm() * 180 / M_PI);
    across.push_back(e.segment<2>(3).norm());
    along.push_back(std::abs(e(5)));
    normalised.push_back(mended.normalised);
    after.push_back(mended.after);
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

/// KITTI's pairs as a stream, extrinsics wrong by 0.5°, 1° and 2° about each axis, both ways: how
/// many are noticed, and how far from the published extrinsics the pairs lead back; and evidence
/// under the published ones.
void kitti_stream(benchmark::State& state) {
  const char* data = std::getenv("INFUSE_REAL_DATA");
  const auto stream = watch::kitti::read_stream(std::filesystem::path(data == nullptr ? "" : data) /
                                                "calibration/kitti");
  if (stream.pictures.empty()) return state.SkipWithError("INFUSE_REAL_DATA has no KITTI pairs");
  std::vector<double> degrees, metres;
  double noticed = 0, certain = 0, usable = 0, all = 0, evidence = 0;
  for (auto _ : state) {
    watch::Watch right(stream.camera, stream.T_camera_lidar, {});
    evidence = watch::kitti::drive(right, stream, 4).evidence;
    for (const double size : {0.5, -0.5, 1.0, -1.0, 2.0, -2.0}) {
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Isometry3d wrong =
            geometry::exp(size * M_PI / 180 * Vector6::Unit(axis)) * stream.T_camera_lidar;
        watch::Watch watch(stream.camera, wrong, {});
        const Drift drift = watch::kitti::drive(watch, stream, 4).drift;
        noticed += drift == Drift::kSuspect || drift == Drift::kDrifted ? 1 : 0;
        certain += drift == Drift::kDrifted ? 1 : 0;
        const watch::Reestimate found = watch::kitti::estimate(stream, wrong);
        const Vector6 error = geometry::log(found.T_camera_lidar * stream.T_camera_lidar.inverse());
        std::fprintf(stderr, "%+.1f degrees about axis %d: %.3f deg, %.1f cm %s\n", size, axis,
                     error.head<3>().norm() * 180 / M_PI, 100 * error.tail<3>().norm(),
                     found.reason.c_str());
        ++all;
        if (!found.usable()) continue;
        ++usable;
        degrees.push_back(error.head<3>().norm() * 180 / M_PI);
        metres.push_back(error.tail<3>().norm());
      }
    }
    state.SetIterationTime(1);
  }
  state.counters["faults"] = all;
  state.counters["noticed"] = noticed;
  state.counters["certain"] = certain;
  state.counters["usable"] = usable;
  state.counters["evidence_unperturbed"] = evidence;
  if (degrees.empty()) return;
  state.counters["rotation_worst_deg"] = quantile(degrees, 1);
  state.counters["translation_worst_m"] = quantile(metres, 1);
}

/// Processor time of a re-estimation from 30 scenes of 1.3 megapixels.
void reestimate(benchmark::State& state) {
  const Drive drive = read_drive(large_drives().front());
  watch::Watch watch(drive.intrinsics, drive.T_camera_lidar, {});
  for (const Pair& pair : drive.pairs) {
    if (watch.scenes().size() == 30) break;
    watch.take(pair.grey, view_of(pair.sweep), {pair.angular_rate, pair.velocity});
  }
  std::vector<watch::StoredScene> scenes;
  watch.scenes().copy(Stamp::earliest(), scenes);
  const Eigen::Isometry3d wrong =
      geometry::exp(kHalfDegree * Vector6::Unit(1)) * drive.T_camera_lidar;
  for (auto _ : state) {
    benchmark::DoNotOptimize(watch::reestimate(scenes, drive.intrinsics, wrong, {}));
  }
  state.counters["scenes"] = static_cast<double>(scenes.size());
}

/// Processor time of a look at a picture of 1.3 megapixels and a sweep of 64 beams.
void look(benchmark::State& state) {
  std::optional<Pair> pair;
  std::optional<watch::Watch> watch;
  int seen = 0;
  for_each_pair(large_drives().front(), [&](const Truth& truth, Pair& next) {
    if (++seen != 40) return;  // somewhere in the middle
    pair = std::move(next);
    watch.emplace(truth.intrinsics, truth.T_camera_lidar, watch::WatchOptions{});
  });
  if (!pair) return state.SkipWithError("no drive");
  int64_t next = 0;
  for (auto _ : state) {
    pair->grey.stamp = Stamp::from_ns(500'000'000 * ++next);
    pair->grey.pixels[static_cast<size_t>(next) % 1000] ^= 1;
    benchmark::DoNotOptimize(
        watch->take(pair->grey, view_of(pair->sweep), {.velocity = Eigen::Vector3d(0, 0, 9)}));
  }
  state.counters["returns"] = static_cast<double>(pair->sweep.size());
}

struct Kind {
  const char* name;
  std::vector<int> axes;
  size_t faults;
  double within;
};

int add_all() {
  const std::vector<Kind> kinds = {{"online/detect/rotation_0.5_deg", {0, 1, 2}, 100, 20},
                                   {"online/detect/translation_xy_5_cm", {3, 4}, 60, 60}};
  const std::vector<std::pair<std::string, Who>> everyone = {
      {"", Who::kWatch},
      {"/baseline:mutual-information", Who::kInformation},
      {"/baseline:levinson-thrun", Who::kLevinson}};
  const auto add = [](const std::string& name, const auto& run) {
    return benchmark::RegisterBenchmark(name.c_str(), run)
        ->UseManualTime()
        ->Iterations(1)
        ->Unit(benchmark::kSecond);
  };
  for (const auto& [suffix, who] : everyone) {
    for (const Kind& kind : kinds) {
      // The grid of 728 poses takes long: a quarter of the faults.
      const size_t faults = who == Who::kLevinson ? kind.faults / 4 : kind.faults;
      add(kind.name + suffix, [kind, faults, who = who](benchmark::State& state) {
        detect(state, kind.axes, faults, kind.within, who);
      });
    }
    add("online/false_alarms" + suffix,
        [who = who](benchmark::State& state) { false_alarms(state, who); });
  }
  add("online/slow_drift", slow_drift);
  add("online/recalibrate", [](benchmark::State& state) { recalibrate(state, 50); });
  add("online/kitti", kitti_stream);
  benchmark::RegisterBenchmark("online/reestimate", reestimate)->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("online/look", look)->Unit(benchmark::kMillisecond);
  return 0;
}

const int kAdded = add_all();

}  // namespace
}  // namespace infuse::online

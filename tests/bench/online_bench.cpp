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

#include "fusion/watch/decision.hpp"
#include "tests/bench/levinson_thrun.hpp"
#include "tests/bench/online_drive.hpp"
#include "tests/bench/rendered_drive.hpp"

namespace infuse::online {
namespace {

using geometry::Vector6;
using watch::Drift;
using watch::view_of;

constexpr double kNever = 1e9;
constexpr size_t kFirstFault = 50;  // pairs; half a second each

const Drive& drive_of(const std::string& scenario) {
  static std::map<std::string, std::unique_ptr<Drive>> drives;
  std::unique_ptr<Drive>& drive = drives[scenario];
  if (drive) return *drive;
  auto read = read_drive(rendered_drive(scenario));
  drive = std::make_unique<Drive>(read ? *std::move(read) : Drive{});
  return *drive;
}

const std::vector<std::string> kConditions = {"online_2hz", "online_overcast", "online_low_sun",
                                              "online_dusk", "online_jam"};

/// A fault of the rig that the watch is given, from a pair on.
struct Fault {
  Vector6 off = Vector6::Zero();
  size_t from = 0;
};

/// Steps of one kind at several moments, both signs, each axis of it alone.
std::vector<Fault> steps(const std::vector<int>& axes, double size) {
  std::vector<Fault> faults;
  for (size_t moment = 0; moment < 4; ++moment) {
    for (const int axis : axes) {
      for (const double sign : {1.0, -1.0}) {
        faults.push_back({sign * size * Vector6::Unit(axis), kFirstFault + 12 * moment});
      }
    }
  }
  return faults;
}

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
/// how many were found in `within` seconds.
void detect(benchmark::State& state, const std::string& name, const std::vector<int>& axes,
            double size, double within, Who who) {
  const Drive& drive = drive_of("online_2hz");
  std::vector<double> suspect, certain;
  for (auto _ : state) {
    // The grid of 728 poses takes long: a sixth of the faults.
    std::vector<Fault> faults = steps(axes, size);
    if (who == Who::kLevinson) faults.resize(faults.size() / 4);
    for (const Fault& fault : faults) {
      const Delay delay = who == Who::kLevinson ? notice_levinson(drive, fault)
                                                : notice(drive, fault, options_of(who));
      suspect.push_back(delay.suspect);
      certain.push_back(delay.certain);
    }
    state.SetIterationTime(std::min(quantile(certain, 0.5), 600.0));
  }
  const auto found =
      std::count_if(certain.begin(), certain.end(), [&](double s) { return s <= within; });
  state.counters["found_percent"] =
      100.0 * static_cast<double>(found) / static_cast<double>(certain.size());
  state.counters["suspect_p98_s"] = std::min(quantile(suspect, 0.98), 600.0);
  state.counters["drifted_p98_s"] = std::min(quantile(certain, 0.98), 600.0);
  state.SetLabel(name);
}

/// Looks without an alarm, in all conditions, as drive hours a false alarm (one counted where there
/// was none); the most evidence that was seen, nats.
void false_alarms(benchmark::State& state, Who who) {
  double hours = 0;
  int alarms = 0;
  double most = 0;
  for (auto _ : state) {
    for (const std::string& condition : kConditions) {
      const Drive& drive = drive_of(condition);
      if (drive.pairs.empty()) continue;
      watch::Watch watch(drive.intrinsics, drive.T_camera_lidar, options_of(who));
      LevinsonThrun levinson(drive.intrinsics, drive.T_camera_lidar);
      bool raised = false;
      for (const Pair& pair : drive.pairs) {
        bool alarm = false;
        if (who == Who::kLevinson) {
          alarm = levinson.take(pair.grey, view_of(pair.sweep));
        } else {
          const auto report =
              watch.take(pair.grey, view_of(pair.sweep), {pair.angular_rate, pair.velocity});
          alarm = report.drift == Drift::kDrifted;
          most = std::max(most, report.evidence);
        }
        alarms += alarm && !raised ? 1 : 0;
        raised = alarm;
      }
      hours += to_seconds(drive.pairs.back().grey.stamp - drive.pairs.front().grey.stamp) / 3600;
    }
    state.SetIterationTime(1);
  }
  state.counters["items_per_second"] = hours / std::max(1, alarms);
  state.counters["false_alarms"] = alarms;
  state.counters["drive_hours"] = hours;
  state.counters["most_evidence"] = most;
  state.SetLabel("h of drive an alarm");
}

/// The whole loop: a step of the rig, alarm, re-estimation, applied. Rotation and translation error
/// of what is in use at the end, medians and worst, degrees; normalised squared error a degree of
/// freedom.
void recalibrate(benchmark::State& state) {
  const Drive& drive = drive_of("online_2hz");
  std::vector<double> degrees, metres, normalised, seconds;
  int applied = 0;
  int runs = 0;
  for (auto _ : state) {
    for (const Fault& fault :
         {Fault{0.0087 * Vector6::Unit(0), 50}, Fault{-0.0087 * Vector6::Unit(1), 60},
          Fault{0.0087 * Vector6::Unit(2), 55}, Fault{-0.05 * Vector6::Unit(3), 50}}) {
      ++runs;
      watch::Watch watch(drive.intrinsics, drive.T_camera_lidar, {});
      const Eigen::Isometry3d wrong = geometry::exp(fault.off) * drive.T_camera_lidar;
      watch::Decision decision(wrong, {.policy = watch::Policy::kApply});
      std::vector<watch::StoredScene> scenes;
      for (size_t i = 0; i < drive.pairs.size(); ++i) {
        const Pair& pair = drive.pairs[i];
        if (i == fault.from) watch.misplace(wrong);
        const auto report =
            watch.take(pair.grey, view_of(pair.sweep), {pair.angular_rate, pair.velocity});
        if (i < fault.from) continue;
        const auto decided = decision.take(report, watch.scenes().count_since(report.since));
        if (decided.calibration_changed) watch.set_calibration(decision.present());
        if (decided.alternative_changed) watch.set_alternative(decision.alternative());
        if (decided.start) {
          watch.scenes().copy(decided.since, scenes);
          const auto begin = std::clock();
          decision.finish(watch::reestimate(scenes, drive.intrinsics, decision.present(), {}));
          seconds.push_back(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
        }
      }
      const Vector6 error = geometry::log(decision.present() * drive.T_camera_lidar.inverse());
      degrees.push_back(error.head<3>().norm() * 180 / M_PI);
      metres.push_back(error.tail<3>().norm());
      if (decision.covariance()) {
        ++applied;
        normalised.push_back(error.dot(decision.covariance()->inverse() * error) / 6);
      }
    }
    state.SetIterationTime(seconds.empty() ? 600 : quantile(seconds, 0.5));
  }
  state.counters["applied_percent"] = 100.0 * applied / runs;
  state.counters["rotation_deg"] = quantile(degrees, 0.5);
  state.counters["rotation_worst_deg"] = quantile(degrees, 1);
  state.counters["translation_m"] = quantile(metres, 0.5);
  state.counters["translation_worst_m"] = quantile(metres, 1);
  if (!normalised.empty()) {
    double sum = 0;
    for (const double one : normalised) sum += one / static_cast<double>(normalised.size());
    state.counters["normalised_error"] = sum;
  }
}

/// Processor time of a look at a picture of 1.3 megapixels and a sweep of 64 beams.
void look(benchmark::State& state) {
  const Drive& drive = drive_of("online_2hz");
  const CameraIntrinsics camera{
      .width = 1280, .height = 1024, .fx = 800, .fy = 800, .cx = 640, .cy = 512};
  const Pair& pair = drive.pairs[40];
  // The small picture twice as large, and every return again and again.
  CameraFrame grey = pair.grey;
  grey.width = camera.width;
  grey.height = camera.height;
  grey.pixels.resize(static_cast<size_t>(camera.width) * static_cast<size_t>(camera.height));
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      grey.pixels[static_cast<size_t>(v * camera.width + u)] =
          pair.grey
              .pixels[static_cast<size_t>(std::min(v / 2, pair.grey.height - 1) * pair.grey.width +
                                          std::min(u / 2, pair.grey.width - 1))];
    }
  }
  Sweep sweep;
  const size_t copies = 125'000 / std::max<size_t>(1, pair.sweep.size()) + 1;
  sweep.resize(copies * pair.sweep.size());
  for (size_t i = 0; i < sweep.size(); ++i) {
    const size_t k = i / copies;
    sweep.x[i] = pair.sweep.x[k];
    sweep.y[i] = pair.sweep.y[k];
    sweep.z[i] = pair.sweep.z[k];
    sweep.range[i] = pair.sweep.range[k];
    sweep.reflectivity[i] = pair.sweep.reflectivity[k];
    sweep.ring[i] = static_cast<uint16_t>(pair.sweep.ring[k] * 2 + i % 2);
    sweep.column[i] = pair.sweep.column[k];
  }
  watch::Watch watch(camera, drive.T_camera_lidar, {});
  int64_t next = 0;
  for (auto _ : state) {
    grey.stamp = Stamp::from_ns(500'000'000 * ++next);
    grey.pixels[static_cast<size_t>(next) % 1000] ^= 1;
    benchmark::DoNotOptimize(
        watch.take(grey, view_of(sweep), {.velocity = Eigen::Vector3d(0, 0, 9)}));
  }
}

struct Kind {
  const char* name;
  std::vector<int> axes;
  double size;
  double within;
};

int add_all() {
  const std::vector<Kind> kinds = {{"online/detect/rotation_0.5_deg", {0, 1, 2}, 0.0087, 20},
                                   {"online/detect/translation_xy_5_cm", {3, 4}, 0.05, 60}};
  const std::vector<std::pair<std::string, Who>> everyone = {
      {"", Who::kWatch},
      {"/baseline:mutual-information", Who::kInformation},
      {"/baseline:levinson-thrun", Who::kLevinson}};
  for (const auto& [suffix, who] : everyone) {
    for (const Kind& kind : kinds) {
      benchmark::RegisterBenchmark((kind.name + suffix).c_str(),
                                   [kind, who = who](benchmark::State& state) {
                                     detect(state, "to certainty, median", kind.axes, kind.size,
                                            kind.within, who);
                                   })
          ->UseManualTime()
          ->Iterations(1)
          ->Unit(benchmark::kSecond);
    }
    benchmark::RegisterBenchmark(("online/false_alarms" + suffix).c_str(),
                                 [who = who](benchmark::State& state) { false_alarms(state, who); })
        ->UseManualTime()
        ->Iterations(1);
  }
  benchmark::RegisterBenchmark("online/recalibrate", recalibrate)
      ->UseManualTime()
      ->Iterations(1)
      ->Unit(benchmark::kSecond);
  benchmark::RegisterBenchmark("online/look", look)->Unit(benchmark::kMillisecond);
  return 0;
}

const int kAdded = add_all();

}  // namespace
}  // namespace infuse::online

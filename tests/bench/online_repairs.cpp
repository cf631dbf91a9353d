// What follows a confirmed drift on simulated drives and on KITTI: accuracy of the calibration that
// is then in use, cost of an evaluation and of a re-estimation.

#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>

#include "drivers/measurement/angles.hpp"
#include "tests/bench/online_loop.hpp"
#include "tests/bench/online_scenarios.hpp"
#include "tests/fusion/monitoring/kitti_stream.hpp"

namespace infuse::online {
namespace {

using monitoring::Drift;
using monitoring::make_sweep_view;

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

const int kRepairsRegistered = [] {
  register_run("online/recalibrate", [](benchmark::State& state) { recalibrate(state, 50); });
  register_run("online/kitti", kitti_stream);
  benchmark::RegisterBenchmark("online/reestimate", reestimate)->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("online/evaluation", evaluate_pair)->Unit(benchmark::kMillisecond);
  return 0;
}();

}  // namespace
}  // namespace infuse::online

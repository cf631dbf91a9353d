// Calibration of other sensor pairs in a synthetic world with known truth: a time-of-flight camera
// (P 3.4.4, fig. 3.22), a planar scanner (P 3.4.5, fig. 3.23), and a lidar without reflectivity
// (P 6.2.1), against the number of scans. Times are processor seconds per calibration.

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <random>

#include "daemon/process/process_times.hpp"
#include "drivers/measurement/angles.hpp"
#include "fusion/calibration/calibrate.hpp"
#include "fusion/calibration/named_measures.hpp"
#include "tests/fusion/calibration/painted_world.hpp"

namespace infuse::calibration {
namespace {

using geometry::Vector6;

struct SensorPair {
  const char* name;
  painted::Scanner scanner;
  double scale;  ///< of the world
  const char* measure;
  int max_scans;  ///< maximum number of scans; twice as many are simulated
};

// A time-of-flight camera with 176 x 144 pixels and 1 cm of noise, in a room; a planar scanner of
// 270 degrees in steps of a quarter degree, 100 degrees of it in the camera's view.
const SensorPair kSensorPairs[] = {
    {"time_of_flight",
     {.rings = 144, .low = -17, .high = 17, .columns = 176, .half_width = 22, .range_noise = 0.01},
     0.4,
     "joint",
     40},
    {"planar_scanner",
     {.rings = 1, .low = 0, .high = 0, .columns = 401, .half_width = 50, .range_noise = 0.01},
     0.5,
     "joint",
     400},
    {"edges_only", {}, 1, "edges", 80}};

const painted::Drive& cached_drive(const SensorPair& pair) {
  static std::map<std::string, painted::Drive> all;
  const auto at = all.find(pair.name);
  if (at != all.end()) return at->second;
  return all.emplace(pair.name, painted::make_drive(2 * pair.max_scans, pair.scale, pair.scanner))
      .first->second;
}

/// Random scenes from initial poses within ± 1° and 5 cm: root mean square error, three axes
/// summed.
void spread(benchmark::State& state, const SensorPair& pair) {
  constexpr int kDraws = 5;
  const painted::Drive& drive = cached_drive(pair);
  const NamedMeasure& measure = *find_measure(pair.measure);
  CalibrateOptions options;
  options.terms = measure.terms;
  options.search_terms = measure.search_terms;
  Vector6 squares = Vector6::Zero();
  int usable = 0;
  double seconds = 0;
  for (auto _ : state) {
    std::mt19937_64 random(1);
    const auto draw = [&] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0; };
    for (int k = 0; k < kDraws; ++k) {
      std::vector<size_t> order(drive.scenes.size());
      for (size_t i = 0; i < order.size(); ++i) order[i] = i;
      for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
      std::vector<Scene> scenes;
      for (size_t i = 0; i < static_cast<size_t>(state.range(0)); ++i) {
        scenes.push_back(drive.scenes[order[i]]);
      }
      Vector6 perturbation;
      for (int axis = 0; axis < 6; ++axis)
        perturbation(axis) = draw() * (axis < 3 ? kDegree : 0.05);
      const double began = daemon::process_cpu_s();
      const CalibrationResult result = calibrate(
          scenes, drive.cameras, geometry::exp(perturbation) * drive.T_camera_lidar, options);
      seconds += (daemon::process_cpu_s() - began) / kDraws;
      usable += result.usable() ? 1 : 0;
      if (!result.usable()) std::fprintf(stderr, "%s: %s\n", pair.name, result.reason.c_str());
      squares += geometry::log(result.T_refcam_lidar * drive.T_camera_lidar.inverse()).cwiseAbs2() /
                 kDraws;
    }
    state.SetIterationTime(seconds);
  }
  state.counters["error_deg"] = std::sqrt(squares.head<3>().sum()) / kDegree;
  state.counters["error_m"] = std::sqrt(squares.tail<3>().sum());
  state.counters["usable_of_5"] = usable;
}

int register_benchmarks() {
  for (const SensorPair& pair : kSensorPairs) {
    auto* one =
        benchmark::RegisterBenchmark((std::string("calibration/pairs/") + pair.name).c_str(),
                                     [&pair](benchmark::State& state) { spread(state, pair); })
            ->UseManualTime()
            ->Iterations(1)
            ->Unit(benchmark::kSecond);
    for (const int part : {8, 4, 2, 1}) one->Arg(pair.max_scans / part);
  }
  return 0;
}

const int kRegistered = register_benchmarks();

}  // namespace
}  // namespace infuse::calibration

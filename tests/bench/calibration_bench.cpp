// Target-less calibration of simulated drives, whose truth is known: what starts reach, what each
// measure reaches on the same scans, how the spread falls with the number of scans and what is told
// of it (P fig. 3.16, I fig. 4.9). Times are processor seconds of a calibration.
//
// Drives are rendered once (`rendered_drive.hpp`). INFUSE_STARTS says how many starts are tried; 10
// otherwise.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <random>

#include "daemon/commands/calibration_run.hpp"
#include "fusion/calibration/named_measures.hpp"
#include "fusion/geometry/extrinsic_error.hpp"
#include "tests/bench/rendered_drive.hpp"

namespace infuse::daemon {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

constexpr double kDegree = M_PI / 180;

const ScenePairs& pairs_of(const std::string& scenario) {
  static std::map<std::string, ScenePairs> all;
  if (const auto at = all.find(scenario); at != all.end()) return at->second;
  auto pairs = read_scene_pairs({.drives = {rendered_drive(scenario).string()}, .scenes = 20},
                                [](double) {});
  if (!pairs || !pairs->truth) {
    std::fprintf(stderr, "%s: cannot be read, or has no truth\n", scenario.c_str());
    std::exit(1);
  }
  return all.emplace(scenario, *std::move(pairs)).first->second;
}

/// Some of the pairs.
ScenePairs part_of(const ScenePairs& pairs, const std::vector<size_t>& chosen) {
  ScenePairs part{.cameras = pairs.cameras, .lidar = pairs.lidar, .rig = pairs.rig};
  part.truth = pairs.truth;
  for (const size_t k : chosen) part.pairs.push_back(pairs.pairs[k]);
  return part;
}

struct Outcome {
  Vector6 error = Vector6::Zero();
  double rotation = 0, translation = 0;  // rad, m
  calibration::CalibrationResult result;
  double cpu_s = 0;
};

Outcome run(const ScenePairs& pairs, const char* measure, const Eigen::Isometry3d& start,
            const calibration::CalibrateOptions& options) {
  const auto done = run_calibration(pairs, *calibration::find_measure(measure), start, options);
  if (!done) return {.rotation = M_PI, .translation = 1e3};
  const auto error = geometry::extrinsic_error(done->result.T_head_lidar, *pairs.truth,
                                               done->cameras.front().model);
  return {.error = geometry::log(done->result.T_head_lidar * pairs.truth->inverse()),
          .rotation = error.rotation,
          .translation = error.translation,
          .result = done->result,
          .cpu_s = done->cpu_s};
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<size_t>(share * static_cast<double>(values.size())))];
}

/// From starts within ± 10° and 10 cm: how many come home (0.1°, 3 cm), how many of the others are
/// called usable, the worst of those at home.
void starts(benchmark::State& state, const std::string& scenario) {
  const ScenePairs& pairs = pairs_of(scenario);
  const char* given = std::getenv("INFUSE_STARTS");
  const int count = given == nullptr ? 10 : std::atoi(given);
  std::mt19937_64 random(1);
  int home = 0, wrong = 0;
  double rotation = 0, translation = 0;
  std::vector<double> seconds;
  for (auto _ : state) {
    for (int k = 0; k < count; ++k) {
      calibration::CalibrateOptions options;
      options.screen.half_width = 10 * kDegree;
      const Outcome outcome =
          run(pairs, "joint", perturbed(*pairs.truth, 10 * kDegree, 0.1, random), options);
      seconds.push_back(outcome.cpu_s);
      if (outcome.rotation < 0.1 * kDegree && outcome.translation < 0.03) {
        ++home;
        rotation = std::max(rotation, outcome.rotation);
        translation = std::max(translation, outcome.translation);
      } else if (outcome.result.usable()) {
        ++wrong;
      }
    }
    state.SetIterationTime(quantile(seconds, 0.5));
  }
  state.counters["home_percent"] = 100.0 * home / count;
  state.counters["usable_but_wrong"] = wrong;
  state.counters["worst_home_deg"] = rotation / kDegree;
  state.counters["worst_home_m"] = translation;
}

/// What a measure reaches from within ± 1° and 5 cm: the median of a few starts, on the same scans.
void reach(benchmark::State& state, const std::string& scenario, const char* measure) {
  const ScenePairs& pairs = pairs_of(scenario);
  std::vector<double> rotation, translation, seconds;
  for (auto _ : state) {
    std::mt19937_64 random(2);
    for (int k = 0; k < 3; ++k) {
      const Outcome outcome =
          run(pairs, measure, perturbed(*pairs.truth, kDegree, 0.05, random), {});
      rotation.push_back(outcome.rotation);
      translation.push_back(outcome.translation);
      seconds.push_back(outcome.cpu_s);
    }
    state.SetIterationTime(quantile(seconds, 0.5));
  }
  state.counters["median_deg"] = quantile(rotation, 0.5) / kDegree;
  state.counters["median_m"] = quantile(translation, 0.5);
}

/// The spread of estimates from so many scans drawn at random, and what each tells of its own
/// uncertainty: standard deviations over all axes, root mean square.
void spread(benchmark::State& state, const std::string& scenario) {
  constexpr int kDraws = 8;
  const ScenePairs& pairs = pairs_of(scenario);
  Vector6 squares = Vector6::Zero(), told = Vector6::Zero(), bound = Vector6::Zero();
  std::vector<double> seconds;
  for (auto _ : state) {
    std::mt19937_64 random(3);
    for (int k = 0; k < kDraws; ++k) {
      std::vector<size_t> order(pairs.pairs.size());
      for (size_t i = 0; i < order.size(); ++i) order[i] = i;
      for (size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
      order.resize(std::min(order.size(), static_cast<size_t>(state.range(0))));
      calibration::CalibrateOptions options;
      options.screen.kept = 0;
      options.restarts = 0;
      const Outcome outcome = run(part_of(pairs, order), "joint", *pairs.truth, options);
      squares += outcome.error.cwiseAbs2() / kDraws;
      told += outcome.result.uncertainty.covariance.diagonal() / kDraws;
      bound += outcome.result.uncertainty.bound.diagonal() / kDraws;
      seconds.push_back(outcome.cpu_s);
    }
    state.SetIterationTime(quantile(seconds, 0.5));
  }
  const auto degrees = [](const Vector6& v) { return std::sqrt(v.head<3>().sum()) / kDegree; };
  const auto metres = [](const Vector6& v) { return std::sqrt(v.tail<3>().sum()); };
  state.counters["error_deg"] = degrees(squares);
  state.counters["told_deg"] = degrees(told);
  state.counters["bound_deg"] = degrees(bound);
  state.counters["error_m"] = metres(squares);
  state.counters["told_m"] = metres(told);
  state.counters["bound_m"] = metres(bound);
}

int add_all() {
  const auto add = [](const std::string& name, auto&& function) {
    return benchmark::RegisterBenchmark(name.c_str(), function)
        ->UseManualTime()
        ->Iterations(1)
        ->Unit(benchmark::kSecond);
  };
  for (const char* scenario : {"calibration_street", "calibration_garage", "calibration_low_sun"}) {
    const std::string where = std::string(scenario).substr(12);
    add("calibration/starts/" + where,
        [scenario](benchmark::State& state) { starts(state, scenario); });
    for (const auto& measure : calibration::named_measures()) {
      if (!measure.has_gradient) continue;  // minutes each
      add("calibration/measure/" + where + "/" + measure.name,
          [scenario, name = measure.name](benchmark::State& state) {
            reach(state, scenario, name);
          });
    }
    add("calibration/scans/" + where,
        [scenario](benchmark::State& state) { spread(state, scenario); })
        ->Arg(5)
        ->Arg(10)
        ->Arg(15);
  }
  return 0;
}

const int kAdded = add_all();

}  // namespace
}  // namespace infuse::daemon

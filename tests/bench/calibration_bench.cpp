// Target-less calibration of simulated drives with known truth. Times are processor seconds per
// calibration.
//
//   convergence  convergence basin for initial poses within ±10°, ±10 cm
//   measure      accuracy of each measure on the same scans (P table 3.1, I fig. 4.9)
//   features     accuracy of BLSMI with subsets of the lidar features (I fig. 4.11)
//   bags         accuracy of BLSMI against the number of bags (I fig. 4.12)
//   scans        spread of the estimates against the number of scans, with the estimated standard
//                deviation and the bound (P fig. 3.16), also for Levinson and Thrun's measure (P
//                fig. 3.20)
//   single       accuracy of single scans (P fig. 3.14)
//   cameras      two cameras of a ring, calibrated separately, against each other (P fig. 3.19)
//
// Drives are rendered once (`rendered_drive.hpp`). INFUSE_INITIAL_GUESSES sets the number of
// initial poses; the default is 10.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <random>

#include "daemon/tools/calibrate/calibration_run.hpp"
#include "drivers/measurement/angles.hpp"
#include "fusion/geometry/extrinsic_error.hpp"
#include "tests/bench/quantile.hpp"
#include "tests/bench/rendered_drive.hpp"
#include "tests/study/calibration/compared_measures.hpp"

namespace infuse::daemon {
namespace {

using geometry::Matrix6;
using geometry::Vector6;

/// Pairs of a drive and one of its cameras; read once.
const ScenePairs& load_pairs(const std::filesystem::path& drive, const std::string& camera,
                             int scenes) {
  static std::map<std::string, ScenePairs> all;
  const std::string key = drive.string() + " " + camera;
  if (const auto at = all.find(key); at != all.end()) return at->second;
  auto pairs = read_scene_pairs(
      {.drives = {drive.string()}, .cameras = {camera}, .max_scenes = scenes}, [](double) {});
  if (!pairs || !pairs->truth) {
    std::fprintf(stderr, "%s: cannot be read, or has no truth\n", drive.c_str());
    std::exit(1);
  }
  return all.emplace(key, *std::move(pairs)).first->second;
}

const ScenePairs& load_pairs(const std::string& scenario) {
  return load_pairs(rendered_drive(scenario), "", 20);
}

/// Pairs of a drive twice as long: forty scans.
const ScenePairs& load_forty_pairs(const std::string& scenario) {
  return load_pairs(rendered_drive(scenario, scenario + "_40", " --duration 42"), "", 40);
}

/// Selects pairs by index.
ScenePairs select_pairs(const ScenePairs& pairs, const std::vector<size_t>& chosen) {
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

using calibration::NamedMeasure;

const NamedMeasure& measure_named(const char* name) { return *study::find_any_measure(name); }

Outcome run(const ScenePairs& pairs, const NamedMeasure& measure, const Eigen::Isometry3d& start,
            const calibration::CalibrateOptions& options) {
  const auto done = run_calibration(pairs, measure, start, options);
  if (!done) return {.rotation = M_PI, .translation = 1e3};
  const auto error = geometry::extrinsic_error(done->result.T_refcam_lidar, *pairs.truth,
                                               done->cameras.front().model);
  return {.error = geometry::log(done->result.T_refcam_lidar * pairs.truth->inverse()),
          .rotation = error.rotation,
          .translation = error.translation,
          .result = done->result,
          .cpu_s = done->cpu_s};
}

/// Convergence from initial poses within ± 10° and 10 cm: the share that converges (0.1°, 3 cm),
/// the number of other results reported as usable, and the largest error of the converged ones.
void convergence(benchmark::State& state, const std::string& scenario) {
  const ScenePairs& pairs = load_pairs(scenario);
  const char* given = std::getenv("INFUSE_INITIAL_GUESSES");
  const int count = given == nullptr ? 10 : std::atoi(given);
  std::mt19937_64 random(1);
  int converged = 0, wrong = 0;
  double rotation = 0, translation = 0;
  std::vector<double> seconds;
  for (auto _ : state) {
    for (int k = 0; k < count; ++k) {
      calibration::CalibrateOptions options;
      options.screen.half_width = 10 * kDegree;
      const Outcome outcome = run(pairs, measure_named("joint"),
                                  perturb(*pairs.truth, 10 * kDegree, 0.1, random), options);
      seconds.push_back(outcome.cpu_s);
      if (outcome.rotation < 0.1 * kDegree && outcome.translation < 0.03) {
        ++converged;
        rotation = std::max(rotation, outcome.rotation);
        translation = std::max(translation, outcome.translation);
      } else if (outcome.result.usable()) {
        ++wrong;
      }
    }
    state.SetIterationTime(quantile(seconds, 0.5));
  }
  state.counters["converged_percent"] = 100.0 * converged / count;
  state.counters["usable_but_wrong"] = wrong;
  state.counters["worst_converged_deg"] = rotation / kDegree;
  state.counters["worst_converged_m"] = translation;
}

/// Accuracy of a measure from initial poses within ± 1° and 5 cm: median of a few initial poses, on
/// the same scans.
void accuracy(benchmark::State& state, const ScenePairs& pairs, const NamedMeasure& measure) {
  std::vector<double> rotation, translation, seconds;
  int usable = 0;
  for (auto _ : state) {
    std::mt19937_64 random(2);
    for (int k = 0; k < 3; ++k) {
      const Outcome outcome = run(pairs, measure, perturb(*pairs.truth, kDegree, 0.05, random), {});
      rotation.push_back(outcome.rotation);
      translation.push_back(outcome.translation);
      seconds.push_back(outcome.cpu_s);
      usable += outcome.result.usable() ? 1 : 0;
    }
    state.SetIterationTime(quantile(seconds, 0.5));
  }
  state.counters["median_deg"] = quantile(rotation, 0.5) / kDegree;
  state.counters["median_m"] = quantile(translation, 0.5);
  state.counters["usable"] = usable;
}

/// BLSMI with a subset of the lidar features: r(eflectivity), d(epth edges), n(ormals).
NamedMeasure blsmi_with_features(const std::string& features) {
  using enum calibration::LidarFeature;
  NamedMeasure measure = measure_named("blsmi");
  std::vector<calibration::LidarFeature>& lidar = measure.terms.front().lidar;
  lidar.clear();
  for (const char feature : features) {
    if (feature == 'r') lidar.push_back(kRelativeReflectivity);
    if (feature == 'd') lidar.push_back(kDiscontinuity);
    if (feature == 'n') lidar.insert(lidar.end(), {kNormalX, kNormalY, kNormalZ});
  }
  return measure;
}

NamedMeasure blsmi_with_bags(int bags) {
  NamedMeasure measure = measure_named("blsmi");
  measure.terms.front().bags = bags;
  return measure;
}

/// Options of a local ascent from the truth: error of the scans, not of the search.
calibration::CalibrateOptions ascent_only_options() {
  calibration::CalibrateOptions options;
  options.screen.survivors = 0;
  options.restarts = 0;
  return options;
}

/// Draws `count` of `all` indices at random.
std::vector<size_t> draw_subset(size_t all, size_t count, std::mt19937_64& random) {
  std::vector<size_t> order(all);
  for (size_t i = 0; i < all; ++i) order[i] = i;
  for (size_t i = all; i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  order.resize(std::min(all, count));
  return order;
}

double degrees(const Vector6& squares) { return std::sqrt(squares.head<3>().sum()) / kDegree; }
double metres(const Vector6& squares) { return std::sqrt(squares.tail<3>().sum()); }

/// Spread of the estimates from randomly drawn scans, and their estimated standard deviation: root
/// mean squares, three axes summed.
void spread(benchmark::State& state, const ScenePairs& pairs, const NamedMeasure& measure) {
  constexpr int kDraws = 8;
  Vector6 squares = Vector6::Zero(), variances = Vector6::Zero(), bound = Vector6::Zero();
  std::vector<double> seconds;
  int usable = 0;
  for (auto _ : state) {
    std::mt19937_64 random(3);
    for (int k = 0; k < kDraws; ++k) {
      const auto order =
          draw_subset(pairs.pairs.size(), static_cast<size_t>(state.range(0)), random);
      const Outcome outcome =
          run(select_pairs(pairs, order), measure, *pairs.truth, ascent_only_options());
      squares += outcome.error.cwiseAbs2() / kDraws;
      seconds.push_back(outcome.cpu_s);
      if (!outcome.result.uncertainty.usable()) continue;
      variances += outcome.result.uncertainty.covariance.diagonal();
      bound += outcome.result.uncertainty.cramer_rao_bound.diagonal();
      ++usable;
    }
    state.SetIterationTime(quantile(seconds, 0.5));
  }
  state.counters["error_deg"] = degrees(squares);
  state.counters["error_m"] = metres(squares);
  state.counters["sigma_count"] = usable;
  state.counters["sigma_deg"] = degrees(variances / usable);
  state.counters["bound_deg"] = degrees(bound / usable);
  state.counters["sigma_m"] = metres(variances / usable);
  state.counters["bound_m"] = metres(bound / usable);
}

/// Spread of the estimates from single scans.
void single_scans(benchmark::State& state, const ScenePairs& pairs) {
  std::vector<double> rotation, translation, seconds;
  for (auto _ : state) {
    for (size_t k = 0; k < pairs.pairs.size(); ++k) {
      const Outcome outcome = run(select_pairs(pairs, {k}), measure_named("joint"), *pairs.truth,
                                  ascent_only_options());
      rotation.push_back(outcome.rotation);
      translation.push_back(outcome.translation);
      seconds.push_back(outcome.cpu_s);
    }
    state.SetIterationTime(quantile(seconds, 0.5));
  }
  state.counters["median_deg"] = quantile(rotation, 0.5) / kDegree;
  state.counters["p90_deg"] = quantile(rotation, 0.9) / kDegree;
  state.counters["median_m"] = quantile(translation, 0.5);
  state.counters["p90_m"] = quantile(translation, 0.9);
}

/// Calibrates two cameras of a ring separately and compares the relative pose with the truth.
void cameras(benchmark::State& state, const NamedMeasure& measure) {
  constexpr int kDraws = 6;
  const std::filesystem::path drive = rendered_drive("ring_of_five");
  const ScenePairs& one = load_pairs(drive, "cam1", 40);
  const ScenePairs& other = load_pairs(drive, "cam4", 40);
  Vector6 squares = Vector6::Zero();
  std::vector<double> seconds;
  for (auto _ : state) {
    std::mt19937_64 random(4);
    for (int k = 0; k < kDraws; ++k) {
      const auto count = static_cast<size_t>(state.range(0));
      const auto order = draw_subset(std::min(one.pairs.size(), other.pairs.size()), count, random);
      const Outcome a = run(select_pairs(one, order), measure, *one.truth, ascent_only_options());
      const Outcome b =
          run(select_pairs(other, order), measure, *other.truth, ascent_only_options());
      const Eigen::Isometry3d found = a.result.T_refcam_lidar * b.result.T_refcam_lidar.inverse();
      const Eigen::Isometry3d truth = *one.truth * other.truth->inverse();
      squares += geometry::log(found * truth.inverse()).cwiseAbs2() / kDraws;
      seconds.push_back(a.cpu_s + b.cpu_s);
    }
    state.SetIterationTime(quantile(seconds, 0.5));
  }
  state.counters["error_deg"] = degrees(squares);
  state.counters["error_m"] = metres(squares);
}

int register_benchmarks() {
  const auto add = [](const std::string& name, auto&& function) {
    return benchmark::RegisterBenchmark(name.c_str(), function)
        ->UseManualTime()
        ->Iterations(1)
        ->Unit(benchmark::kSecond);
  };
  for (const char* scenario : {"calibration_street", "calibration_garage", "calibration_low_sun"}) {
    const std::string where = std::string(scenario).substr(12);
    add("calibration/convergence/" + where,
        [scenario](benchmark::State& state) { convergence(state, scenario); });
    for (const auto measures : {calibration::named_measures(), study::compared_measures()}) {
      for (const NamedMeasure& measure : measures) {
        if (!measure.has_gradient) continue;  // minutes each
        add("calibration/measure/" + where + "/" + measure.name,
            [=](benchmark::State& state) { accuracy(state, load_pairs(scenario), measure); });
      }
    }
    for (const char* features : {"r", "d", "n", "rd", "rn", "dn", "rdn"}) {
      add("calibration/features/" + where + "/" + features, [=](benchmark::State& state) {
        accuracy(state, load_pairs(scenario), blsmi_with_features(std::string(features)));
      });
    }
    for (const int bags : {10, 50, 100, 200}) {
      add("calibration/bags/" + where + "/" + std::to_string(bags), [=](benchmark::State& state) {
        accuracy(state, load_pairs(scenario), blsmi_with_bags(bags));
      });
    }
    add("calibration/single/" + where,
        [=](benchmark::State& state) { single_scans(state, load_pairs(scenario)); });
  }
  for (const char* measure : {"joint", "levinson-thrun"}) {
    auto* scans =
        add(std::string("calibration/scans/street/") + measure, [=](benchmark::State& state) {
          spread(state, load_forty_pairs("calibration_street"), measure_named(measure));
        });
    for (const int count : {5, 10, 15, 20, 30, 40}) scans->Arg(count);
  }
  for (const char* measure : {"joint", "mi"}) {
    add(std::string("calibration/cameras/") + measure,
        [=](benchmark::State& state) { cameras(state, measure_named(measure)); })
        ->Arg(10)
        ->Arg(20)
        ->Arg(40);
  }
  return 0;
}

const int kRegistered = register_benchmarks();

}  // namespace
}  // namespace infuse::daemon

// Target-less calibration of simulated drives, whose truth is known. Times are processor seconds of
// a calibration.
//
//   starts    what starts within ±10°, ±10 cm reach
//   measure   what each measure reaches on the same scans (P table 3.1, I fig. 4.9)
//   features  what BLSMI reaches with some of the lidar's features (I fig. 4.11)
//   bags      what BLSMI reaches with so many bags (I fig. 4.12)
//   scans     how the spread falls with the number of scans, beside what is told of it and the
//   bound
//             (P fig. 3.16), and that of Levinson and Thrun's measure (P fig. 3.20)
//   single    what single scans say (P fig. 3.14)
//   cameras   two cameras of a ring, each alone, against each other (P fig. 3.19)
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

/// The pairs of a drive and one of its cameras; read once.
const ScenePairs& pairs_of(const std::filesystem::path& drive, const std::string& camera,
                           int scenes) {
  static std::map<std::string, ScenePairs> all;
  const std::string key = drive.string() + " " + camera;
  if (const auto at = all.find(key); at != all.end()) return at->second;
  auto pairs = read_scene_pairs({.drives = {drive.string()}, .cameras = {camera}, .scenes = scenes},
                                [](double) {});
  if (!pairs || !pairs->truth) {
    std::fprintf(stderr, "%s: cannot be read, or has no truth\n", drive.c_str());
    std::exit(1);
  }
  return all.emplace(key, *std::move(pairs)).first->second;
}

const ScenePairs& pairs_of(const std::string& scenario) {
  return pairs_of(rendered_drive(scenario), "", 20);
}

/// Twice as long: forty scans.
const ScenePairs& forty_of(const std::string& scenario) {
  return pairs_of(rendered_drive(scenario, scenario + "_40", " --duration 42"), "", 40);
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

using calibration::NamedMeasure;

const NamedMeasure& named(const char* name) { return *calibration::find_measure(name); }

Outcome run(const ScenePairs& pairs, const NamedMeasure& measure, const Eigen::Isometry3d& start,
            const calibration::CalibrateOptions& options) {
  const auto done = run_calibration(pairs, measure, start, options);
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
          run(pairs, named("joint"), perturbed(*pairs.truth, 10 * kDegree, 0.1, random), options);
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
void reach(benchmark::State& state, const ScenePairs& pairs, const NamedMeasure& measure) {
  std::vector<double> rotation, translation, seconds;
  int usable = 0;
  for (auto _ : state) {
    std::mt19937_64 random(2);
    for (int k = 0; k < 3; ++k) {
      const Outcome outcome =
          run(pairs, measure, perturbed(*pairs.truth, kDegree, 0.05, random), {});
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

/// BLSMI of some of the lidar's features: r(eflectivity), d(epth edges), n(ormals).
NamedMeasure blsmi_of(const std::string& features) {
  using enum calibration::LidarFeature;
  NamedMeasure measure = named("blsmi");
  std::vector<calibration::LidarFeature>& lidar = measure.terms.front().lidar;
  lidar.clear();
  for (const char feature : features) {
    if (feature == 'r') lidar.push_back(kRelativeReflectivity);
    if (feature == 'd') lidar.push_back(kDiscontinuity);
    if (feature == 'n') lidar.insert(lidar.end(), {kNormalX, kNormalY, kNormalZ});
  }
  return measure;
}

NamedMeasure blsmi_of(int bags) {
  NamedMeasure measure = named("blsmi");
  measure.terms.front().bags = bags;
  return measure;
}

/// A climb from the truth alone: what the scans say, not what the search finds.
calibration::CalibrateOptions from_the_truth() {
  calibration::CalibrateOptions options;
  options.screen.kept = 0;
  options.restarts = 0;
  return options;
}

/// `count` of `all` places, at random.
std::vector<size_t> draw(size_t all, size_t count, std::mt19937_64& random) {
  std::vector<size_t> order(all);
  for (size_t i = 0; i < all; ++i) order[i] = i;
  for (size_t i = all; i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  order.resize(std::min(all, count));
  return order;
}

double degrees(const Vector6& squares) { return std::sqrt(squares.head<3>().sum()) / kDegree; }
double metres(const Vector6& squares) { return std::sqrt(squares.tail<3>().sum()); }

/// The spread of estimates from so many scans drawn at random, and what each tells of its own
/// uncertainty: root of the mean squares, summed over three axes.
void spread(benchmark::State& state, const ScenePairs& pairs, const NamedMeasure& measure) {
  constexpr int kDraws = 8;
  Vector6 squares = Vector6::Zero(), told = Vector6::Zero(), bound = Vector6::Zero();
  std::vector<double> seconds;
  int usable = 0;
  for (auto _ : state) {
    std::mt19937_64 random(3);
    for (int k = 0; k < kDraws; ++k) {
      const auto order = draw(pairs.pairs.size(), static_cast<size_t>(state.range(0)), random);
      const Outcome outcome = run(part_of(pairs, order), measure, *pairs.truth, from_the_truth());
      squares += outcome.error.cwiseAbs2() / kDraws;
      seconds.push_back(outcome.cpu_s);
      if (!outcome.result.uncertainty.usable()) continue;
      told += outcome.result.uncertainty.covariance.diagonal();
      bound += outcome.result.uncertainty.bound.diagonal();
      ++usable;
    }
    state.SetIterationTime(quantile(seconds, 0.5));
  }
  state.counters["error_deg"] = degrees(squares);
  state.counters["error_m"] = metres(squares);
  state.counters["told_of"] = usable;
  state.counters["told_deg"] = degrees(told / usable);
  state.counters["bound_deg"] = degrees(bound / usable);
  state.counters["told_m"] = metres(told / usable);
  state.counters["bound_m"] = metres(bound / usable);
}

/// The spread of what single scans say.
void single(benchmark::State& state, const ScenePairs& pairs) {
  std::vector<double> rotation, translation, seconds;
  for (auto _ : state) {
    for (size_t k = 0; k < pairs.pairs.size(); ++k) {
      const Outcome outcome =
          run(part_of(pairs, {k}), named("joint"), *pairs.truth, from_the_truth());
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

/// Two cameras of a ring calibrated each alone: how far off is where one seems to stand, seen from
/// the other.
void cameras(benchmark::State& state, const NamedMeasure& measure) {
  constexpr int kDraws = 6;
  const std::filesystem::path drive = rendered_drive("ring_of_five");
  const ScenePairs& one = pairs_of(drive, "cam1", 40);
  const ScenePairs& other = pairs_of(drive, "cam4", 40);
  Vector6 squares = Vector6::Zero();
  std::vector<double> seconds;
  for (auto _ : state) {
    std::mt19937_64 random(4);
    for (int k = 0; k < kDraws; ++k) {
      const auto count = static_cast<size_t>(state.range(0));
      const auto order = draw(std::min(one.pairs.size(), other.pairs.size()), count, random);
      const Outcome a = run(part_of(one, order), measure, *one.truth, from_the_truth());
      const Outcome b = run(part_of(other, order), measure, *other.truth, from_the_truth());
      const Eigen::Isometry3d found = a.result.T_head_lidar * b.result.T_head_lidar.inverse();
      const Eigen::Isometry3d truth = *one.truth * other.truth->inverse();
      squares += geometry::log(found * truth.inverse()).cwiseAbs2() / kDraws;
      seconds.push_back(a.cpu_s + b.cpu_s);
    }
    state.SetIterationTime(quantile(seconds, 0.5));
  }
  state.counters["error_deg"] = degrees(squares);
  state.counters["error_m"] = metres(squares);
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
    for (const NamedMeasure& measure : calibration::named_measures()) {
      if (!measure.has_gradient) continue;  // minutes each
      add("calibration/measure/" + where + "/" + measure.name,
          [=](benchmark::State& state) { reach(state, pairs_of(scenario), measure); });
    }
    for (const char* features : {"r", "d", "n", "rd", "rn", "dn", "rdn"}) {
      add("calibration/features/" + where + "/" + features, [=](benchmark::State& state) {
        reach(state, pairs_of(scenario), blsmi_of(std::string(features)));
      });
    }
    for (const int bags : {10, 50, 100, 200}) {
      add("calibration/bags/" + where + "/" + std::to_string(bags),
          [=](benchmark::State& state) { reach(state, pairs_of(scenario), blsmi_of(bags)); });
    }
    add("calibration/single/" + where,
        [=](benchmark::State& state) { single(state, pairs_of(scenario)); });
  }
  for (const char* measure : {"joint", "levinson-thrun"}) {
    auto* scans =
        add(std::string("calibration/scans/street/") + measure, [=](benchmark::State& state) {
          spread(state, forty_of("calibration_street"), named(measure));
        });
    for (const int count : {5, 10, 15, 20, 30, 40}) scans->Arg(count);
  }
  for (const char* measure : {"joint", "mi"}) {
    add(std::string("calibration/cameras/") + measure,
        [=](benchmark::State& state) { cameras(state, named(measure)); })
        ->Arg(10)
        ->Arg(20)
        ->Arg(40);
  }
  return 0;
}

const int kAdded = add_all();

}  // namespace
}  // namespace infuse::daemon

#include <benchmark/benchmark.h>

#include <random>

#include "fusion/streetmap/rasterise.hpp"
#include "fusion/streetmap/tracker.hpp"

namespace infuse::streetmap {
namespace {

/// Two crossing streets with kerbs, and samples with features by the kind of ground.
struct Crossing {
  std::vector<std::byte> bytes;
  SegmentMap map;
  GridSamples samples;

  Crossing() {
    StreetPlan plan;
    plan.strips.push_back(
        {{SegmentKind::kCarriageway, 1}, {{-150, 0}, {150, 0}}, 3, 0.4, 2.4, 2.4});
    plan.strips.push_back({{SegmentKind::kCarriageway, 2}, {{0, -90}, {0, 90}}, 3, 0.4, 2.4, 2.4});
    bytes = *rasterise(plan, {.margin = 60}, "crossing");
    map = *SegmentMap::open(bytes, "crossing");
    constexpr int kSamples = 1500;
    std::mt19937_64 random(1);
    std::uniform_real_distribution<float> place(-20, 20);
    std::normal_distribution<double> noise;
    samples.features.resize(kSamples, kFeatureCount);
    for (int i = 0; i < kSamples; ++i) {
      samples.x.push_back(place(random));
      samples.y.push_back(place(random));
      const double level =
          static_cast<double>(map.segment(map.id_at(samples.x.back(), samples.y.back())).kind);
      for (int f = 0; f < kFeatureCount; ++f)
        samples.features(i, f) = level * (f % 3) / 3 + noise(random);
    }
  }
};

/// One update of 100 particles, of which the share `omission` is not cross-validated.
void update(benchmark::State& state, double omission) {
  const Crossing crossing;
  TrackerOptions options;
  options.skipped_validation_share = omission;
  options.max_validated = 100;
  options.particles.min_count = options.particles.max_count = 100;
  Tracker tracker(crossing.map, options);
  tracker.start({}, Eigen::Vector3d(0.25, 0.25, 0.003).asDiagonal());
  double step = 0.31;  // back and forth: enough for an update
  for (auto _ : state) {
    tracker.predict({step, 0, 0}, Eigen::Matrix3d::Zero(), Duration(500'000'000));
    tracker.update(crossing.samples);
    step = -step;
  }
}

void update_omitting_90(benchmark::State& state) { update(state, 0.9); }
void update_all(benchmark::State& state) { update(state, 0); }

BENCHMARK(update_omitting_90)->Name("streetmap/update")->Unit(benchmark::kMillisecond);
BENCHMARK(update_all)
    ->Name("streetmap/update/baseline:all_validated")
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace infuse::streetmap

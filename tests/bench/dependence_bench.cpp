#include <benchmark/benchmark.h>

#include <cmath>
#include <random>
#include <vector>

#include "fusion/dependence/prepared_histogram.hpp"

namespace infuse::dependence {
namespace {

constexpr size_t kSamples = 300000;
constexpr int kBins = 32;

/// Reflectivity and grey values in 0 … 1 as from a lidar and a camera: two correlated sides.
struct Pairs {
  std::vector<float> reflectivity = std::vector<float>(kSamples);
  std::vector<float> grey = std::vector<float>(kSamples);
  Pairs() {
    std::mt19937 random(1);
    std::normal_distribution<double> draw;
    for (size_t i = 0; i < kSamples; ++i) {
      const double x = draw(random), y = 0.6 * x + 0.8 * draw(random);
      reflectivity[i] = static_cast<float>(0.5 + std::erf(x / std::sqrt(2)) / 2);
      grey[i] = static_cast<float>(0.5 + std::erf(y / std::sqrt(2)) / 2);
    }
  }
};

const Pairs& pairs() {
  static const Pairs made;
  return made;
}

/// The same measure, implemented straightforwardly in double precision.
class NaiveMutualInformation {
 public:
  double value(const std::vector<float>& x, const std::vector<float>& y) {
    p_.assign(kBins * kBins, 0.0);
    for (size_t i = 0; i < x.size(); ++i) {
      const BinWeights a(x[i]), b(y[i]);
      for (int k = 0; k < 4; ++k) {
        for (int l = 0; l < 4; ++l) {
          p_[cell(a.first + k, b.first + l)] += a.weight[k] * b.weight[l];
        }
      }
    }
    px_.assign(kBins, 0.0);
    py_.assign(kBins, 0.0);
    for (int k = 0; k < kBins; ++k) {
      for (int l = 0; l < kBins; ++l) {
        p_[cell(k, l)] /= static_cast<double>(x.size());
        px_[size_t(k)] += p_[cell(k, l)];
        py_[size_t(l)] += p_[cell(k, l)];
      }
    }
    double information = 0;
    for (int k = 0; k < kBins; ++k) {
      for (int l = 0; l < kBins; ++l) {
        const double p = p_[cell(k, l)];
        if (p > 0) information += p * std::log(p / (px_[size_t(k)] * py_[size_t(l)]));
      }
    }
    return information;
  }

  double value_and_gradient(const std::vector<float>& x, const std::vector<float>& y,
                            std::vector<double>& gradient) {
    const double information = value(x, y);
    std::vector<double> ratio(kBins * kBins);
    for (int k = 0; k < kBins; ++k) {
      for (int l = 0; l < kBins; ++l) {
        const double p = p_[cell(k, l)];
        ratio[cell(k, l)] = p > 0 ? std::log(p / py_[size_t(l)]) : 0;
      }
    }
    gradient.resize(x.size());
    for (size_t i = 0; i < x.size(); ++i) {
      const BinWeights a(x[i]), b(y[i]);
      double sum = 0;
      for (int k = 0; k < 4; ++k) {
        for (int l = 0; l < 4; ++l) {
          sum += a.weight[k] * b.slope[l] * ratio[cell(a.first + k, b.first + l)];
        }
      }
      gradient[i] = sum * (kBins - 3) / static_cast<double>(x.size());
    }
    return information;
  }

 private:
  struct BinWeights {
    int first;
    double weight[4], slope[4];
    explicit BinWeights(double value) {
      const double t = value * (kBins - 3);
      first = std::min(static_cast<int>(t), kBins - 4);
      const double f = t - first, g = 1 - f;
      weight[0] = g * g * g / 6;
      weight[1] = (3 * f * f * f - 6 * f * f + 4) / 6;
      weight[2] = (3 * g * g * g - 6 * g * g + 4) / 6;
      weight[3] = f * f * f / 6;
      slope[0] = -g * g / 2;
      slope[1] = (3 * f * f - 4 * f) / 2;
      slope[2] = -(3 * g * g - 4 * g) / 2;
      slope[3] = f * f / 2;
    }
  };
  static size_t cell(int k, int l) { return static_cast<size_t>(k * kBins + l); }
  std::vector<double> p_, px_, py_;
};

void mi_value(benchmark::State& state) {
  PreparedHistogram prepared(pairs().reflectivity, {});
  for (auto _ : state) {
    benchmark::DoNotOptimize(prepared.value(Measure::kMutualInformation, pairs().grey));
  }
}
BENCHMARK(mi_value)->Name("dependence/mi_value_300k")->Unit(benchmark::kMillisecond);

void mi_value_naive(benchmark::State& state) {
  NaiveMutualInformation baseline;
  for (auto _ : state) {
    benchmark::DoNotOptimize(baseline.value(pairs().reflectivity, pairs().grey));
  }
}
BENCHMARK(mi_value_naive)
    ->Name("dependence/mi_value_300k/baseline:naive_double")
    ->Unit(benchmark::kMillisecond);

void mi_gradient(benchmark::State& state) {
  PreparedHistogram prepared(pairs().reflectivity, {});
  std::vector<float> gradient(kSamples);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        prepared.value_and_gradient(Measure::kMutualInformation, pairs().grey, gradient));
  }
}
BENCHMARK(mi_gradient)->Name("dependence/mi_gradient_300k")->Unit(benchmark::kMillisecond);

void mi_gradient_naive(benchmark::State& state) {
  NaiveMutualInformation baseline;
  std::vector<double> gradient;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        baseline.value_and_gradient(pairs().reflectivity, pairs().grey, gradient));
  }
}
BENCHMARK(mi_gradient_naive)
    ->Name("dependence/mi_gradient_300k/baseline:naive_double")
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace infuse::dependence

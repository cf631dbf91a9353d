// Least-squares mutual information with one side prepared, against a new solve per hypothesis as in
// the papers.

#include <benchmark/benchmark.h>

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "fusion/dependence/bagged_lsmi.hpp"
#include "fusion/dependence/prepared_dependence.hpp"

namespace infuse::dependence {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// --- plain LSMI, I(2.7-2.8) and I 2.2.2.2, in Eigen ---

MatrixXd plain_kernel(const MatrixXd& samples, const MatrixXd& centres, double sigma) {
  // |x|² − 2xᵀc + |c|², so that Eigen's matrix product does the work.
  MatrixXd distance = -2 * samples * centres.transpose();
  distance.colwise() += samples.rowwise().squaredNorm();
  distance.rowwise() += centres.rowwise().squaredNorm().transpose();
  return (distance.array() * (-0.5 / (sigma * sigma))).exp();
}

struct PlainSolution {
  Eigen::SelfAdjointEigenSolver<MatrixXd> x, y;
  MatrixXd rotated;

  PlainSolution(const MatrixXd& k, const MatrixXd& l) {
    const double n = static_cast<double>(k.rows());
    x.compute(k.transpose() * k / n);
    y.compute(l.transpose() * l / n);
    rotated = x.eigenvectors().transpose() * (k.transpose() * l / n) * y.eigenvectors();
  }
  MatrixXd theta(double lambda) const {
    const MatrixXd divisor = (x.eigenvalues() * y.eigenvalues().transpose()).array() + lambda;
    return x.eigenvectors() * rotated.cwiseQuotient(divisor) * y.eigenvectors().transpose();
  }
};

double plain_lsmi(const MatrixXd& k, const MatrixXd& l, double lambda) {
  const MatrixXd theta = PlainSolution(k, l).theta(lambda);
  return 0.5 * (k * theta).cwiseProduct(l).sum() / static_cast<double>(k.rows()) - 0.5;
}

double plain_error(const MatrixXd& k, const MatrixXd& l, const MatrixXd& theta) {
  const double n = static_cast<double>(k.rows());
  const MatrixXd k_theta = k * theta;
  return 0.5 * (k_theta * l.transpose()).squaredNorm() / (n * n) -
         k_theta.cwiseProduct(l).sum() / n;
}

// Assigns samples to folds in turn; the samples are in random order.
double plain_lsmi_cross_validated(const MatrixXd& x, const MatrixXd& centres, const MatrixXd& l,
                                  const FitOptions& options) {
  const Eigen::Index n = x.rows();
  double best = std::numeric_limits<double>::max(), best_lambda = 0;
  MatrixXd best_kernel;
  for (const double sigma : options.sigmas) {
    const MatrixXd k = plain_kernel(x, centres, sigma);
    std::vector<double> errors(options.lambdas.size(), 0.0);
    for (int fold = 0; fold < options.folds; ++fold) {
      const Eigen::Index begin = n * fold / options.folds, end = n * (fold + 1) / options.folds;
      const Eigen::Index held_out = end - begin;
      MatrixXd k_train(n - held_out, k.cols()), l_train(n - held_out, l.cols());
      k_train << k.topRows(begin), k.bottomRows(n - end);
      l_train << l.topRows(begin), l.bottomRows(n - end);
      const PlainSolution solution(k_train, l_train);
      for (size_t j = 0; j < errors.size(); ++j) {
        errors[j] += plain_error(k.middleRows(begin, held_out), l.middleRows(begin, held_out),
                                 solution.theta(options.lambdas[j]));
      }
    }
    const auto min_error = std::min_element(errors.begin(), errors.end());
    if (*min_error >= best) continue;
    best = *min_error;
    best_lambda = options.lambdas[static_cast<size_t>(min_error - errors.begin())];
    best_kernel = k;
  }
  return plain_lsmi(best_kernel, l, best_lambda);
}

// --- street map: many labellings of one set of cells ---

struct StreetMap {
  static constexpr int kHypotheses = 100, kCells = 625, kFeatures = 6, kLabels = 8;
  MatrixXd features{kCells, kFeatures};
  std::vector<std::vector<int32_t>> labels;
  FitOptions options;

  StreetMap() {
    std::mt19937_64 random(4);
    std::normal_distribution<double> noise;
    std::uniform_int_distribution<int32_t> any(0, kLabels - 1);
    std::vector<int32_t> truth(kCells);
    for (int i = 0; i < kCells; ++i) {
      truth[static_cast<size_t>(i)] = any(random);
      for (int f = 0; f < kFeatures; ++f) {
        const double level = ((truth[static_cast<size_t>(i)] * (f + 3)) % kLabels) / 8.0;
        features(i, f) = 0.5 * level + 0.2 * noise(random);
      }
    }
    for (int h = 0; h < kHypotheses; ++h) {
      labels.push_back(truth);
      for (int32_t& label : labels.back()) {
        if (std::uniform_int_distribution<int>(0, kHypotheses)(random) < h) label = any(random);
      }
    }
    options.centres = 40;
    options.sigmas = {0.1, 0.2, 0.4, 0.8, 1.6};
  }

  MatrixXd indicators(size_t hypothesis) const {
    MatrixXd l = MatrixXd::Zero(kCells, kLabels);
    for (int i = 0; i < kCells; ++i) l(i, labels[hypothesis][static_cast<size_t>(i)]) = 1;
    return l;
  }
};

// Includes the preparation of the cells, which a tracker does once per update.
void hypotheses_cv(benchmark::State& state) {
  const StreetMap map;
  for (auto _ : state) {
    PreparedDependence prepared(FitMeasure::kSmi, map.features, map.options);
    for (const auto& labels : map.labels) {
      benchmark::DoNotOptimize(prepared.evaluate(labels, StreetMap::kLabels).value);
    }
  }
}
BENCHMARK(hypotheses_cv)->Name("dependence/lsmi_100_hypotheses_cv")->Unit(benchmark::kMillisecond);

void hypotheses_cv_plain(benchmark::State& state) {
  const StreetMap map;
  for (auto _ : state) {
    const MatrixXd centres = map.features.topRows(map.options.centres);
    for (size_t h = 0; h < map.labels.size(); ++h) {
      benchmark::DoNotOptimize(
          plain_lsmi_cross_validated(map.features, centres, map.indicators(h), map.options));
    }
  }
}
BENCHMARK(hypotheses_cv_plain)
    ->Name("dependence/lsmi_100_hypotheses_cv/baseline:plain_eigen")
    ->Unit(benchmark::kMillisecond);

// A tracker whose particles keep σ and λ prepares the cells for that σ only.
void hypotheses_fixed(benchmark::State& state) {
  const StreetMap map;
  FitOptions options = map.options;
  options.sigmas = {0.4};
  options.lambdas = {0.01};
  for (auto _ : state) {
    PreparedDependence prepared(FitMeasure::kSmi, map.features, options);
    for (const auto& labels : map.labels) {
      benchmark::DoNotOptimize(prepared.evaluate(labels, StreetMap::kLabels).value);
    }
  }
}
BENCHMARK(hypotheses_fixed)
    ->Name("dependence/lsmi_100_hypotheses_fixed")
    ->Unit(benchmark::kMillisecond);

void hypotheses_fixed_plain(benchmark::State& state) {
  const StreetMap map;
  for (auto _ : state) {
    const MatrixXd centres = map.features.topRows(map.options.centres);
    for (size_t h = 0; h < map.labels.size(); ++h) {
      benchmark::DoNotOptimize(
          plain_lsmi(plain_kernel(map.features, centres, 0.4), map.indicators(h), 0.01));
    }
  }
}
BENCHMARK(hypotheses_fixed_plain)
    ->Name("dependence/lsmi_100_hypotheses_fixed/baseline:plain_eigen")
    ->Unit(benchmark::kMillisecond);

// --- calibration: bags, and a gradient with respect to six parameters ---

struct Calibration {
  static constexpr int kBags = 200, kBagSize = 2000, kCentres = 100, kParameters = 6;
  static constexpr int kPlainBags = 4;  // bags timed by the baseline; its time is scaled to kBags
  static constexpr int kSamples = 20000, kFixedFeatures = 3, kMovingFeatures = 6;
  static constexpr HyperParameters kHyperParameters{1.0, 0.01};
  MatrixXd fixed{kSamples, kFixedFeatures}, moving{kSamples, kMovingFeatures};
  std::vector<MatrixXd> jacobian;  // ∂moving/∂parameter

  Calibration() {
    std::mt19937_64 random(5);
    std::normal_distribution<double> noise;
    for (int i = 0; i < kSamples; ++i) {
      for (int f = 0; f < kFixedFeatures; ++f) fixed(i, f) = noise(random);
      for (int f = 0; f < kMovingFeatures; ++f)
        moving(i, f) = 0.6 * fixed(i, f % 3) + 0.8 * noise(random);
    }
    for (int p = 0; p < kParameters; ++p) {
      jacobian.push_back(
          MatrixXd::NullaryExpr(kSamples, kMovingFeatures, [&]() { return noise(random); }));
    }
  }
  MatrixXd moved(int parameter, double step) const {
    return moving + step * jacobian[static_cast<size_t>(parameter)];
  }
};

void blsmi_gradient(benchmark::State& state) {
  const Calibration calibration;
  BagOptions options;
  options.bags = Calibration::kBags;
  options.bag_size = Calibration::kBagSize;
  options.fit.centres = Calibration::kCentres;
  BaggedLsmi bagged(calibration.fixed, options);
  bagged.set_hyper_parameters(Calibration::kHyperParameters);
  MatrixXd gradient;
  for (auto _ : state) {
    benchmark::DoNotOptimize(bagged.evaluate(calibration.moving, &gradient).value);
    VectorXd by_parameter(Calibration::kParameters);
    for (int p = 0; p < Calibration::kParameters; ++p) {
      by_parameter[p] = gradient.cwiseProduct(calibration.jacobian[static_cast<size_t>(p)]).sum();
    }
    benchmark::DoNotOptimize(by_parameter.data());
  }
}
BENCHMARK(blsmi_gradient)->Name("dependence/blsmi_gradient")->Unit(benchmark::kMillisecond);

// Solves each bag anew for the value and for both ends of six central differences. The time of
// kPlainBags bags is scaled to that of all bags.
void blsmi_gradient_plain(benchmark::State& state) {
  const Calibration calibration;
  std::mt19937_64 random(6);
  std::vector<int> order(Calibration::kSamples);
  std::iota(order.begin(), order.end(), 0);
  const auto value = [&](const MatrixXd& moving) {
    double sum = 0;
    for (int b = 0; b < Calibration::kPlainBags; ++b) {
      const std::vector<int> rows(order.begin() + b * Calibration::kBagSize,
                                  order.begin() + (b + 1) * Calibration::kBagSize);
      const MatrixXd x = calibration.fixed(rows, Eigen::all), y = moving(rows, Eigen::all);
      const double sigma = Calibration::kHyperParameters.sigma;
      sum += plain_lsmi(plain_kernel(x, x.topRows(Calibration::kCentres), sigma),
                        plain_kernel(y, y.topRows(Calibration::kCentres), sigma),
                        Calibration::kHyperParameters.lambda);
    }
    return sum / Calibration::kPlainBags;
  };
  for (auto _ : state) {
    std::shuffle(order.begin(), order.end(), random);
    const auto begin = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(value(calibration.moving));
    for (int p = 0; p < Calibration::kParameters; ++p) {
      constexpr double kStep = 1e-4;
      benchmark::DoNotOptimize(
          (value(calibration.moved(p, kStep)) - value(calibration.moved(p, -kStep))) / (2 * kStep));
    }
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
    state.SetIterationTime(elapsed.count() * Calibration::kBags / Calibration::kPlainBags);
  }
  state.SetLabel("4 bags timed, scaled to 200");
}
BENCHMARK(blsmi_gradient_plain)
    ->Name("dependence/blsmi_gradient/baseline:plain_eigen_central_differences")
    ->UseManualTime()
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace infuse::dependence

#include "tests/study/dependence/estimators.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fusion/dependence/bagged_lsmi.hpp"
#include "fusion/dependence/directed_information.hpp"
#include "fusion/dependence/prepared_dependence.hpp"
#include "fusion/dependence/prepared_histogram.hpp"
#include "tests/study/dependence/distance_correlation.hpp"
#include "tests/study/dependence/paired_density_ratio.hpp"

namespace infuse::study {
namespace {

using namespace dependence;

const double kMutualInformation = -0.5 * std::log(1 - kRho * kRho);
const double kSquaredLossMi = kRho * kRho / (2 * (1 - kRho * kRho));
const double kQuadraticMi =
    (1 / (4 * std::sqrt(1 - kRho * kRho)) + 0.25 - 1 / std::sqrt(4 - kRho * kRho)) /
    std::numbers::pi;
const double kConditionalEntropy =
    -1 / (4 * std::sqrt(1 - kRho * kRho) * std::sqrt(std::numbers::pi));  // without its constant
const double kDistanceCorrelation =
    std::sqrt((kRho * std::asin(kRho) + std::sqrt(1 - kRho * kRho) - kRho * std::asin(kRho / 2) -
               std::sqrt(4 - kRho * kRho) + 1) /
              (1 + std::numbers::pi / 3 - std::numbers::sqrt3));

std::vector<float> row_as_floats(const SamplePairs& samples, Eigen::Index row) {
  std::vector<float> values(static_cast<size_t>(samples.cols()));
  for (Eigen::Index i = 0; i < samples.cols(); ++i) {
    values[static_cast<size_t>(i)] = static_cast<float>(samples(row, i));
  }
  return values;
}

/// Histogram over −4 … 4 with 1.5 ∛n bins per side, at most 32.
JointHistogram make_histogram(const SamplePairs& samples, Window window) {
  const double root = 1.5 * std::cbrt(static_cast<double>(samples.cols()));
  const Axis axis{.bins = std::min(32, static_cast<int>(std::lround(root))), .low = -4, .high = 4};
  return joint_histogram(row_as_floats(samples, 0), row_as_floats(samples, 1),
                         {.x = axis, .y = axis, .window = window});
}

Estimator windowed(const std::string& key, const std::string& name, Measure which, Window window) {
  const bool information = which == Measure::kMutualInformation;
  const double truth = information                     ? kMutualInformation
                       : which == Measure::kChiSquared ? 2 * kSquaredLossMi
                                                       : kSquaredLossMi;
  const char* quantity = information ? "MI" : which == Measure::kChiSquared ? "χ²" : "SMI";
  return {key, name, quantity, truth,
          [=](const SamplePairs& s) { return measure(which, make_histogram(s, window)); }};
}

/// Directed information of the signs as labels: P(both positive) = ¼ + asin(ρ)/2π gives the truth.
Estimator directed_information_of_signs() {
  const double agree = 0.5 + std::asin(kRho) / std::numbers::pi;
  const double truth = std::log(2) + agree * std::log(agree) + (1 - agree) * std::log(1 - agree);
  return {"directed-information", "directed information rate, memory 1", "DI of signs", truth,
          [](const SamplePairs& s) {
            std::vector<int32_t> x, y;
            for (Eigen::Index i = 0; i < s.cols(); ++i) {
              x.push_back(s(0, i) > 0);
              y.push_back(s(1, i) > 0);
            }
            return directed_information_rate(x, y, 1);
          }};
}

/// Least-squares fit with its default grid, cross-validated.
Estimator fitted(const std::string& key, const std::string& name, const char* quantity,
                 double truth, FitMeasure which, SmiForm form = SmiForm::kLinear) {
  FitOptions options;
  options.form = form;
  return {key,
          name,
          quantity,
          truth,
          [=](const SamplePairs& s) {
            const Eigen::VectorXd x = s.row(0), y = s.row(1);
            return PreparedDependence(which, x, options).evaluate(y);
          },
          12};
}

/// Twenty bags with half of the samples each, at most 2000.
Estimate bagged(const SamplePairs& samples) {
  const Eigen::VectorXd x = samples.row(0), y = samples.row(1);
  BagOptions options;
  options.bags = 20;
  options.bag_size = std::min(2000, static_cast<int>(x.size() / 2));
  return BaggedLsmi(x, options).evaluate(y);
}

/// Estimator of two sides with one feature each.
template <class Answer>
Estimator paired(const std::string& key, const std::string& name, const char* quantity,
                 double truth, Answer answer, int max_trials = 200) {
  return {key,
          name,
          quantity,
          truth,
          [=](const SamplePairs& s) {
            const Eigen::VectorXd x = s.row(0), y = s.row(1);
            return Estimate(answer(x, y));
          },
          max_trials};
}

}  // namespace

std::vector<Estimator> make_estimators() {
  return {
      windowed("mi-histogram", "histogram, no window", Measure::kMutualInformation, Window::kNone),
      windowed("mi-gaussian-window", "histogram, Gaussian window", Measure::kMutualInformation,
               Window::kGaussian),
      windowed("mi-spline-window", "histogram, B-spline window", Measure::kMutualInformation,
               Window::kBSpline),
      windowed("smi-histogram", "histogram, no window", Measure::kSquaredLossMutualInformation,
               Window::kNone),
      windowed("smi-spline-window", "histogram, B-spline window",
               Measure::kSquaredLossMutualInformation, Window::kBSpline),
      windowed("chi2-spline-window", "histogram, B-spline window", Measure::kChiSquared,
               Window::kBSpline),
      directed_information_of_signs(),
      fitted("smi-lsmi", "LSMI, I(2.8)", "SMI", kSquaredLossMi, FitMeasure::kSmi),
      fitted("smi-lsmi-plug-in", "LSMI, plug-in form", "SMI", kSquaredLossMi, FitMeasure::kSmi,
             SmiForm::kPlugIn),
      paired(
          "smi-lsmi-paired", "LSMI, paired model", "SMI", kSquaredLossMi,
          [](const auto& x, const auto& y) { return paired_lsmi(x, y, {}); }, 12),
      {"smi-blsmi", "BLSMI I(2.9), 20 bags", "SMI", kSquaredLossMi, bagged, 12},
      paired(
          "mi-mlmi", "MLMI", "MI", kMutualInformation,
          [](const auto& x, const auto& y) { return mlmi(x, y, {}); }, 5),
      fitted("qmi-lsqmi", "LSQMI", "QMI", kQuadraticMi, FitMeasure::kQmi),
      fitted("sce-lsce", "LSCE", "SCE", kConditionalEntropy, FitMeasure::kSce),
      paired("dcor", "distance correlation", "dCor", kDistanceCorrelation, distance_correlation),
      paired("dcor2-corrected", "the same, bias corrected", "dCor²",
             kDistanceCorrelation * kDistanceCorrelation, corrected_distance_correlation),
  };
}

}  // namespace infuse::study

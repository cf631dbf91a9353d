// Measures the bias and the spread of every estimator of fusion/dependence on the bivariate
// Gaussian, and writes them down: accuracy.md and accuracy.svg.
//
//   dependence_accuracy [FOLDER]    default: fusion/dependence
//
// A new estimator is one more line in `registry()`.

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <iostream>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "fusion/dependence/bagged_lsmi.hpp"
#include "fusion/dependence/directed_information.hpp"
#include "fusion/dependence/distance_correlation.hpp"
#include "fusion/dependence/paired_density_ratio.hpp"
#include "fusion/dependence/prepared_dependence.hpp"
#include "fusion/dependence/prepared_histogram.hpp"
#include "fusion/dependence/sample_entropy.hpp"

namespace infuse::dependence {
namespace {

constexpr double kRho = 0.5;
constexpr int kSizes[] = {100, 1000, 10000};
constexpr int kTrials[] = {200, 100, 30};  // of each size

/// n samples of the standard bivariate Gaussian with correlation kRho, one a column.
using SamplePairs = Eigen::Matrix2Xd;

/// One estimator, and what it should say.
struct Entry {
  std::string name;      ///< as the README calls it
  std::string quantity;  ///< what it estimates
  double truth;          ///< closed form
  std::function<Estimate(const SamplePairs&)> estimate;
  int max_trials = 200;  ///< fewer for what is slow
};

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
const double kScalarEntropy = 0.5 * std::log(2 * std::numbers::pi * std::numbers::e);
const double kJointEntropy = 2 * kScalarEntropy - kMutualInformation;
const double kRenyiHalf =
    std::log(2 * std::numbers::pi) + 0.5 * std::log(1 - kRho * kRho) + std::log(0.5) / (0.5 - 1);

std::vector<float> row_as_floats(const SamplePairs& samples, Eigen::Index row) {
  std::vector<float> values(static_cast<size_t>(samples.cols()));
  for (Eigen::Index i = 0; i < samples.cols(); ++i) {
    values[static_cast<size_t>(i)] = static_cast<float>(samples(row, i));
  }
  return values;
}

/// −4 … 4 in as many bins as 1.5 times the cube root of n, 32 at most.
JointHistogram make_histogram(const SamplePairs& samples, Window window) {
  const double root = 1.5 * std::cbrt(static_cast<double>(samples.cols()));
  const Axis axis{.bins = std::min(32, static_cast<int>(std::lround(root))), .low = -4, .high = 4};
  return joint_histogram(row_as_floats(samples, 0), row_as_floats(samples, 1),
                         {.x = axis, .y = axis, .window = window});
}

Entry windowed(const std::string& name, Measure which, Window window) {
  const bool information = which == Measure::kMutualInformation;
  const double truth = information                     ? kMutualInformation
                       : which == Measure::kChiSquared ? 2 * kSquaredLossMi
                                                       : kSquaredLossMi;
  const char* quantity = information ? "MI" : which == Measure::kChiSquared ? "χ²" : "SMI";
  return {name, quantity, truth,
          [=](const SamplePairs& s) { return measure(which, make_histogram(s, window)); }};
}

Entry corrected(const std::string& name, CountEntropyOptions options) {
  return {name, "MI", kMutualInformation, [=](const SamplePairs& s) {
            return measure(Measure::kMutualInformation, make_histogram(s, Window::kNone), options);
          }};
}

Entry dirichlet(const std::string& name, double (*alpha)(std::span<const double>)) {
  return {name, "MI", kMutualInformation, [=](const SamplePairs& s) {
            const JointHistogram histogram = make_histogram(s, Window::kNone);
            const CountEntropyOptions options{
                .estimator = CountEntropyOptions::Estimator::kDirichlet,
                .alpha = alpha(histogram.mass),
                .shrinkage = {}};
            return measure(Measure::kMutualInformation, histogram, options);
          }};
}

Estimate spacing_entropy_of_x(const SamplePairs& samples, bool correct_bias) {
  const Eigen::VectorXd x = samples.row(0);
  return entropy_spacing({x.data(), static_cast<size_t>(x.size())},
                         {.m = 0, .correct_bias = correct_bias});
}

Estimate information_by_neighbours(const SamplePairs& samples, int k) {
  const Estimate x = entropy_nearest_neighbour(samples.row(0), k);
  const Estimate y = entropy_nearest_neighbour(samples.row(1), k);
  const Estimate xy = entropy_nearest_neighbour(samples, k);
  for (const Estimate& h : {x, y, xy}) {
    if (!h.usable()) return h;
  }
  return {x.value + y.value - xy.value, ""};
}

/// The signs as labels: P(both positive) = ¼ + asin(ρ)/2π gives the truth.
Entry directed_information_of_signs() {
  const double agree = 0.5 + std::asin(kRho) / std::numbers::pi;
  const double truth = std::log(2) + agree * std::log(agree) + (1 - agree) * std::log(1 - agree);
  return {"directed information rate, memory 1", "DI of signs", truth, [](const SamplePairs& s) {
            std::vector<int32_t> x, y;
            for (Eigen::Index i = 0; i < s.cols(); ++i) {
              x.push_back(s(0, i) > 0);
              y.push_back(s(1, i) > 0);
            }
            return directed_information_rate(x, y, 1);
          }};
}

/// A least-squares fit with its default grid, cross-validated.
Entry fitted(const std::string& name, const char* quantity, double truth, FitMeasure which,
             SmiForm form = SmiForm::kLinear) {
  FitOptions options;
  options.form = form;
  return {name, quantity, truth,
          [=](const SamplePairs& s) {
            const Eigen::VectorXd x = s.row(0), y = s.row(1);
            return PreparedDependence(which, x, options).evaluate(y);
          },
          12};
}

/// Twenty bags of half the samples, 2000 at most.
Estimate bagged(const SamplePairs& samples) {
  const Eigen::VectorXd x = samples.row(0), y = samples.row(1);
  BagOptions options;
  options.bags = 20;
  options.bag_size = std::min(2000, static_cast<int>(x.size() / 2));
  return BaggedLsmi(x, options).evaluate(y);
}

/// An estimator of pairs of samples of one feature.
template <class Answer>
Entry paired(const std::string& name, const char* quantity, double truth, Answer answer,
             int max_trials = 200) {
  return {name, quantity, truth,
          [=](const SamplePairs& s) {
            const Eigen::VectorXd x = s.row(0), y = s.row(1);
            return Estimate(answer(x, y));
          },
          max_trials};
}

/// Every estimator that is measured.
std::vector<Entry> registry() {
  using Estimator = CountEntropyOptions::Estimator;
  const auto with_estimator = [](Estimator estimator, double alpha = 0.5) {
    return CountEntropyOptions{.estimator = estimator, .alpha = alpha, .shrinkage = {}};
  };
  return {
      windowed("histogram, no window", Measure::kMutualInformation, Window::kNone),
      windowed("histogram, Gaussian window", Measure::kMutualInformation, Window::kGaussian),
      windowed("histogram, B-spline window", Measure::kMutualInformation, Window::kBSpline),
      corrected("Miller–Madow", with_estimator(Estimator::kMillerMadow)),
      corrected("James–Stein", with_estimator(Estimator::kJamesStein)),
      corrected("Dirichlet, Jeffreys", with_estimator(Estimator::kDirichlet, 0.5)),
      corrected("Dirichlet, Laplace", with_estimator(Estimator::kDirichlet, 1)),
      dirichlet("Dirichlet, Perks", perks_alpha),
      dirichlet("Dirichlet, minimax", minimax_alpha),
      corrected("Dirichlet mixture (Nemenman)", with_estimator(Estimator::kNemenman)),
      corrected("Chao–Shen", with_estimator(Estimator::kChaoShen)),
      {"nearest neighbours, k = 1", "MI", kMutualInformation,
       [](const SamplePairs& s) { return information_by_neighbours(s, 1); }},
      {"nearest neighbours, k = 4", "MI", kMutualInformation,
       [](const SamplePairs& s) { return information_by_neighbours(s, 4); }},
      windowed("histogram, no window", Measure::kSquaredLossMutualInformation, Window::kNone),
      windowed("histogram, B-spline window", Measure::kSquaredLossMutualInformation,
               Window::kBSpline),
      windowed("histogram, B-spline window", Measure::kChiSquared, Window::kBSpline),
      {"m-spacing as printed", "H(x)", kScalarEntropy,
       [](const SamplePairs& s) { return spacing_entropy_of_x(s, false); }},
      {"m-spacing, bias corrected", "H(x)", kScalarEntropy,
       [](const SamplePairs& s) { return spacing_entropy_of_x(s, true); }},
      {"nearest neighbour", "H(x, y)", kJointEntropy,
       [](const SamplePairs& s) { return entropy_nearest_neighbour(s, 1); }},
      {"minimum spanning tree, α = ½", "Rényi H(x, y)", kRenyiHalf,
       [](const SamplePairs& s) { return renyi_entropy_spanning_tree(s); }, 30},
      directed_information_of_signs(),
      fitted("LSMI, I(2.8)", "SMI", kSquaredLossMi, FitMeasure::kSmi),
      fitted("LSMI, plug-in form", "SMI", kSquaredLossMi, FitMeasure::kSmi, SmiForm::kPlugIn),
      paired(
          "LSMI, paired model", "SMI", kSquaredLossMi,
          [](const auto& x, const auto& y) { return paired_lsmi(x, y, {}); }, 12),
      {"BLSMI I(2.9), 20 bags", "SMI", kSquaredLossMi, bagged, 12},
      paired(
          "MLMI", "MI", kMutualInformation,
          [](const auto& x, const auto& y) { return mlmi(x, y, {}); }, 5),
      fitted("LSQMI", "QMI", kQuadraticMi, FitMeasure::kQmi),
      fitted("LSCE", "SCE", kConditionalEntropy, FitMeasure::kSce),
      paired("distance correlation", "dCor", kDistanceCorrelation, distance_correlation),
      paired("the same, bias corrected", "dCor²", kDistanceCorrelation * kDistanceCorrelation,
             corrected_distance_correlation),
  };
}

/// What one estimator did at one sample size.
struct Accuracy {
  double bias = 0, sigma = 0;
  int refused = 0, trials = 0;
};

Accuracy evaluate_accuracy(const Entry& entry, int n, int trials) {
  Accuracy accuracy{.trials = trials};
  std::vector<double> values;
  for (int trial = 0; trial < trials; ++trial) {
    std::mt19937_64 random(static_cast<uint64_t>(n) * 1000 + static_cast<uint64_t>(trial));
    std::normal_distribution<double> draw;
    SamplePairs samples(2, n);
    for (int i = 0; i < n; ++i) {
      const double x = draw(random), noise = draw(random);
      samples.col(i) << x, kRho * x + std::sqrt(1 - kRho * kRho) * noise;
    }
    const Estimate estimate = entry.estimate(samples);
    if (estimate.usable()) {
      values.push_back(estimate.value);
    } else {
      ++accuracy.refused;
    }
  }
  if (values.size() < 2) return accuracy;
  double mean = 0, square = 0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  for (const double v : values) square += (v - mean) * (v - mean);
  accuracy.bias = mean - entry.truth;
  accuracy.sigma = std::sqrt(square / static_cast<double>(values.size() - 1));
  return accuracy;
}

struct Row {
  Entry entry;
  std::vector<Accuracy> accuracies;  ///< one a size
};

std::string format_text(const char* format, double a, double b = 0, double c = 0, double d = 0) {
  char buffer[400];
  std::snprintf(buffer, sizeof buffer, format, a, b, c, d);
  return buffer;
}

std::string markdown(const std::vector<Row>& rows) {
  std::ostringstream out;
  out << "# Accuracy on the bivariate Gaussian\n\n"
      << "Made by `./dev bench dependence`; do not edit. Standard bivariate Gaussian, ρ = 0.5. "
         "Each "
         "cell: bias ± standard\ndeviation of one estimate, in the unit of the quantity (nats for "
         "entropies and information).\n"
      << "Histograms: −4 … 4 in 7, 15 and 32 bins a side. Variance is the square of the standard "
         "deviation; "
         "\"–\" where the estimator\nrefused every set.\n\n"
      << "| estimator | of | truth | n = 100 | n = 1000 | n = 10 000 "
         "|\n|---|---|---|---|---|---|\n";
  for (const Row& row : rows) {
    out << "| " << row.entry.name << " | " << row.entry.quantity << " | "
        << format_text("%.4f", row.entry.truth);
    for (const Accuracy& a : row.accuracies) {
      out << " | "
          << (a.refused + 1 < a.trials ? format_text("%+.4f ± %.4f", a.bias, a.sigma)
                                       : std::string("–"));
    }
    out << " |\n";
  }
  out << "\n![bias and standard deviation relative to the truth](accuracy.svg)\n";
  return out.str();
}

/// One line an estimator; relative error on the abscissa, a dot for the bias and a bar of ± one
/// deviation for each sample size.
std::string plot(const std::vector<Row>& rows) {
  constexpr double kLeft = 330, kWidth = 520, kTop = 50, kStep = 30, kMinError = -1,
                   kMaxError = 1.5;
  const char* const colours[] = {"#c44e52", "#dd8452", "#4c72b0"};
  const auto place = [&](double relative) {
    return kLeft + kWidth * (std::clamp(relative, kMinError, kMaxError) - kMinError) /
                       (kMaxError - kMinError);
  };
  const double bottom = kTop + kStep * static_cast<double>(rows.size());
  std::ostringstream out;
  out << format_text("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" ",
                     kLeft + kWidth + 20, bottom + 40)
      << "font-family=\"sans-serif\" font-size=\"12\">\n"
      << "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  for (int tick = 0; tick <= 5; ++tick) {
    const double relative = kMinError + 0.5 * tick, x = place(relative);
    out << format_text("<line x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\" ", x, x, kTop - 8,
                       bottom)
        << "stroke=\"" << (relative == 0 ? "#555" : "#ddd") << "\"/>\n"
        << format_text("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%+.1f</text>\n", x,
                       bottom + 16, relative);
  }
  out << format_text("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", kLeft + kWidth / 2,
                     bottom + 34)
      << "error relative to the truth: bias ± one standard deviation (cut at the edges)</text>\n";
  for (size_t size = 0; size < std::size(kSizes); ++size) {
    const double x = kLeft + 110 * static_cast<double>(size);
    out << format_text("<circle cx=\"%.1f\" cy=\"20\" r=\"4\" fill=\"", x) << colours[size]
        << "\"/>"
        << format_text("<text x=\"%.1f\" y=\"24\">n = %.0f</text>\n", x + 9, kSizes[size]);
  }
  for (size_t r = 0; r < rows.size(); ++r) {
    const double y = kTop + kStep * static_cast<double>(r) + 6;
    out << format_text("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">", kLeft - 10, y + 10)
        << rows[r].entry.quantity << ": " << rows[r].entry.name << "</text>\n";
    for (size_t size = 0; size < std::size(kSizes); ++size) {
      const Accuracy& a = rows[r].accuracies[size];
      if (a.refused + 1 >= a.trials) continue;
      const double line = y + 6 * static_cast<double>(size);
      const double truth = std::abs(rows[r].entry.truth);
      out << format_text("<line x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\" ",
                         place((a.bias - a.sigma) / truth), place((a.bias + a.sigma) / truth), line,
                         line)
          << "stroke=\"" << colours[size] << "\" stroke-width=\"2\"/>"
          << format_text("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3\" fill=\"", place(a.bias / truth),
                         line)
          << colours[size] << "\"/>\n";
    }
  }
  out << "</svg>\n";
  return out.str();
}

bool write(const std::string& path, const std::string& content) {
  std::ofstream file(path, std::ios::binary);
  file << content;
  file.close();
  if (!file) std::cerr << path << ": cannot be written\n";
  return static_cast<bool>(file);
}

int run(const std::string& folder) {
  std::vector<Row> rows;
  for (Entry& entry : registry()) {
    std::cerr << entry.quantity << ": " << entry.name << '\n';
    Row row{std::move(entry), {}};
    for (size_t size = 0; size < std::size(kSizes); ++size) {
      const int trials = std::min(kTrials[size], row.entry.max_trials);
      row.accuracies.push_back(evaluate_accuracy(row.entry, kSizes[size], trials));
    }
    rows.push_back(std::move(row));
  }
  const bool written =
      write(folder + "/accuracy.md", markdown(rows)) && write(folder + "/accuracy.svg", plot(rows));
  return written ? 0 : 1;
}

}  // namespace
}  // namespace infuse::dependence

int main(int argc, char** argv) {
  return infuse::dependence::run(argc > 1 ? argv[1] : "fusion/dependence");
}

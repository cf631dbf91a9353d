#include "tests/study/dependence/gaussian_accuracy.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ostream>
#include <random>
#include <string>

namespace infuse::study {
namespace {

constexpr int kSizes[] = {100, 1000, 10000};
constexpr int kTrials[] = {200, 100, 30};  // per size

Accuracy evaluate_accuracy(const Estimator& estimator, int n, int trials) {
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
    const Estimate estimate = estimator.estimate(samples);
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
  accuracy.bias = mean - estimator.truth;
  accuracy.sigma = std::sqrt(square / static_cast<double>(values.size() - 1));
  return accuracy;
}

std::string format_text(const char* format, double a, double b = 0, double c = 0, double d = 0) {
  char buffer[400];
  std::snprintf(buffer, sizeof buffer, format, a, b, c, d);
  return buffer;
}

}  // namespace

AccuracyRow measure_accuracy(const Estimator& estimator) {
  AccuracyRow row{estimator, {}};
  for (size_t size = 0; size < std::size(kSizes); ++size) {
    const int trials = std::min(kTrials[size], estimator.max_trials);
    row.accuracies.push_back(evaluate_accuracy(estimator, kSizes[size], trials));
  }
  return row;
}

void write_table(std::ostream& out, const std::vector<AccuracyRow>& rows) {
  out << "# Accuracy on the bivariate Gaussian\n\n"
         "Made by `infuse-study accuracy`; do not edit. Standard bivariate Gaussian, ρ = 0.5.\n"
         "Each cell: bias ± standard deviation of one estimate, in the unit of the quantity\n"
         "(nats for entropies and information). Histograms: −4 … 4 in 7, 15 and 32 bins per\n"
         "side. \"–\": the estimator returned no usable value.\n\n"
         "| estimator | of | truth | n = 100 | n = 1000 | n = 10 000 |\n"
         "|---|---|---|---|---|---|\n";
  for (const AccuracyRow& row : rows) {
    out << "| " << row.estimator.name << " | " << row.estimator.quantity << " | "
        << format_text("%.4f", row.estimator.truth);
    for (const Accuracy& a : row.accuracies) {
      out << " | "
          << (a.refused + 1 < a.trials ? format_text("%+.4f ± %.4f", a.bias, a.sigma)
                                       : std::string("–"));
    }
    out << " |\n";
  }
  out << "\n![bias and standard deviation relative to the truth](accuracy.svg)\n";
}

// One row per estimator; relative error on the abscissa. For each sample size, a dot marks the bias
// and a bar one standard deviation to either side.
void write_plot(std::ostream& out, const std::vector<AccuracyRow>& rows) {
  constexpr double kLeft = 330, kWidth = 520, kTop = 50, kStep = 30, kMinError = -1,
                   kMaxError = 1.5;
  const char* const colours[] = {"#c44e52", "#dd8452", "#4c72b0"};
  const auto place = [&](double relative) {
    return kLeft + kWidth * (std::clamp(relative, kMinError, kMaxError) - kMinError) /
                       (kMaxError - kMinError);
  };
  const double bottom = kTop + kStep * static_cast<double>(rows.size());
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
        << rows[r].estimator.quantity << ": " << rows[r].estimator.name << "</text>\n";
    for (size_t size = 0; size < std::size(kSizes); ++size) {
      const Accuracy& a = rows[r].accuracies[size];
      if (a.refused + 1 >= a.trials) continue;
      const double line = y + 6 * static_cast<double>(size);
      const double truth = std::abs(rows[r].estimator.truth);
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
}

}  // namespace infuse::study

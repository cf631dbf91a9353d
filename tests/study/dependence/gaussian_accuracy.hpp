#pragma once

#include <iosfwd>
#include <vector>

#include "tests/study/dependence/estimators.hpp"

namespace infuse::study {

/// Bias and standard deviation of an estimator at one sample size.
struct Accuracy {
  double bias = 0, sigma = 0;
  int refused = 0, trials = 0;  ///< number of unusable estimates, and of all
};

/// An estimator with its accuracy at each sample size.
struct AccuracyRow {
  Estimator estimator;
  std::vector<Accuracy> accuracies;
};

/// Measures an estimator on the bivariate Gaussian with 100, 1000 and 10 000 samples.
AccuracyRow measure_accuracy(const Estimator& estimator);

/// Writes the table in Markdown.
void write_table(std::ostream& out, const std::vector<AccuracyRow>& rows);

/// Writes a plot in SVG: bias and standard deviation of each estimator relative to the truth.
void write_plot(std::ostream& out, const std::vector<AccuracyRow>& rows);

}  // namespace infuse::study

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/study/dependence/sample_entropy.hpp"

namespace infuse::study {
namespace {

/// Σ |e|^γ over the edges of the Euclidean minimum spanning tree: Prim's algorithm on the complete
/// graph, one pass over the remaining points for each point added.
double tree_length(Eigen::MatrixXd points, double gamma) {
  const Eigen::Index n = points.cols();
  std::vector<double> nearest(static_cast<size_t>(n), std::numeric_limits<double>::infinity());
  double length = 0;
  Eigen::Index joined = 0;  // points [0, joined] are in the tree
  while (joined + 1 < n) {
    Eigen::Index next = joined + 1;
    for (Eigen::Index i = joined + 1; i < n; ++i) {
      const double squared = (points.col(i) - points.col(joined)).squaredNorm();
      double& best = nearest[static_cast<size_t>(i)];
      best = std::min(best, squared);
      if (best < nearest[static_cast<size_t>(next)]) next = i;
    }
    length += std::pow(nearest[static_cast<size_t>(next)], gamma / 2);
    ++joined;
    points.col(next).swap(points.col(joined));
    std::swap(nearest[static_cast<size_t>(next)], nearest[static_cast<size_t>(joined)]);
  }
  return length;
}

constexpr Eigen::Index kMaxSamples = 50000;

const char* check_options(const SpanningTreeOptions& options) {
  if (!(options.alpha > 0 && options.alpha < 1)) return "alpha is not inside (0, 1)";
  if (options.log_beta && !std::isfinite(*options.log_beta)) return "log_beta is not finite";
  if (options.calibration_sets < 1) return "no calibration sets";
  return "";
}

}  // namespace

double spanning_tree_log_beta(int dimensions, int samples, const SpanningTreeOptions& options) {
  if (dimensions < 1 || samples < 2 || samples > kMaxSamples) return 0;
  if (*check_options(options)) return 0;
  std::mt19937_64 random(options.seed);
  Eigen::MatrixXd points(dimensions, samples);
  double length = 0;
  for (int set = 0; set < options.calibration_sets; ++set) {
    for (double& x : points.reshaped()) x = static_cast<double>(random() >> 11) * 0x1p-53;
    length += tree_length(points, dimensions * (1 - options.alpha));
  }
  return std::log(length / options.calibration_sets) - options.alpha * std::log(samples);
}

Estimate renyi_entropy_spanning_tree(const Eigen::Ref<const Eigen::MatrixXd>& samples,
                                     const SpanningTreeOptions& options) {
  if (const char* reason = check_options(options); *reason) return {0, reason};
  if (samples.rows() < 1) return {0, "samples have no dimension"};
  if (samples.cols() < 2) return {0, "fewer than two samples"};
  if (samples.cols() > kMaxSamples) return {0, "more than 50 000 samples: draw a subset"};
  if (!samples.allFinite()) return {0, "a sample is not finite"};
  constexpr double kMaxMagnitude = 1e100;  // keeps squared distances finite
  if (samples.cwiseAbs().maxCoeff() > kMaxMagnitude) return {0, "a sample is above 1e100"};

  const double length =
      tree_length(samples, static_cast<double>(samples.rows()) * (1 - options.alpha));
  if (!(length > 0)) return {0, "all samples are equal"};
  if (!std::isfinite(length)) return {0, "the range of the samples exceeds that of double"};
  constexpr Eigen::Index kMaxCalibrationSamples = 1000;
  const auto dimensions = static_cast<int>(samples.rows());
  const auto sizes = static_cast<int>(std::min(samples.cols(), kMaxCalibrationSamples));
  const double log_beta =
      options.log_beta ? *options.log_beta : spanning_tree_log_beta(dimensions, sizes, options);
  const double log_n = std::log(static_cast<double>(samples.cols()));
  return {(std::log(length) - options.alpha * log_n - log_beta) / (1 - options.alpha), ""};
}

}  // namespace infuse::study

#include "tests/study/dependence/sample_entropy.hpp"

#include <algorithm>
#include <boost/math/special_functions/digamma.hpp>
#include <cmath>
#include <nanoflann.hpp>
#include <numbers>
#include <vector>

namespace infuse::study {
namespace {

using boost::math::digamma;

/// Expected error of P(2.20) on n samples of a uniform density: exact, since the spacings are then
/// Beta distributed. Inside the sample a spacing has 2m steps, at its ends fewer.
double spacing_bias(int n, int m) {
  const double samples = n;
  double edges = 0;
  for (int i = 1; i <= m; ++i) edges += digamma(i + m - 1);
  return std::log(samples / (2.0 * m)) - digamma(samples + 1) +
         (1 - 2.0 * m / samples) * digamma(2.0 * m) + 2 / samples * edges;
}

/// Adaptor of the samples for nanoflann.
struct ColumnPoints {
  const Eigen::Ref<const Eigen::MatrixXd>& samples;
  size_t kdtree_get_point_count() const { return static_cast<size_t>(samples.cols()); }
  double kdtree_get_pt(size_t column, size_t row) const {
    return samples(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column));
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, ColumnPoints>,
                                                 ColumnPoints, -1, size_t>;

double log_unit_ball_volume(double dimensions) {
  return dimensions / 2 * std::log(std::numbers::pi) - std::lgamma(dimensions / 2 + 1);
}

}  // namespace

Estimate entropy_spacing(std::span<const double> samples, const SpacingOptions& options) {
  if (samples.size() < 3) return {0, "fewer than three samples"};
  if (samples.size() > 1u << 30) return {0, "too many samples"};
  for (const double x : samples) {
    if (!std::isfinite(x)) return {0, "a sample is not finite"};
  }
  const auto n = static_cast<int>(samples.size());
  const int default_m = std::min(static_cast<int>(std::lround(std::cbrt(n))), (n - 1) / 2);
  const int m = options.m == 0 ? default_m : options.m;
  if (m < 1 || 2 * m >= n) return {0, "the spacing m is not in 1 ... n/2"};

  std::vector<double> sorted(samples.begin(), samples.end());
  std::sort(sorted.begin(), sorted.end());
  if (sorted.front() == sorted.back()) return {0, "all samples are equal"};
  const auto order_statistic = [&](int k) {
    return sorted[static_cast<size_t>(std::clamp(k, 0, n - 1))];
  };
  double sum = 0;
  for (int k = 0; k < n; ++k) {
    const double spacing = order_statistic(k + m) - order_statistic(k - m);
    if (!(spacing > 0)) return {0, "more equal samples than a spacing covers: no density"};
    sum += std::log(spacing);
  }
  const double h = sum / n + std::log(n / (2.0 * m));
  if (!std::isfinite(h)) return {0, "the range of the samples exceeds that of double"};
  return {options.correct_bias ? h - spacing_bias(n, m) : h, ""};
}

Estimate entropy_nearest_neighbour(const Eigen::Ref<const Eigen::MatrixXd>& samples, int k) {
  if (samples.rows() < 1) return {0, "samples have no dimension"};
  if (k < 1 || samples.cols() <= k) return {0, "k is not in 1 ... n - 1"};
  if (!samples.allFinite()) return {0, "a sample is not finite"};
  constexpr double kMaxMagnitude = 1e100;  // keeps squared distances finite
  if (samples.cwiseAbs().maxCoeff() > kMaxMagnitude) return {0, "a sample is above 1e100"};

  const ColumnPoints points{samples};
  const Tree tree(static_cast<int>(samples.rows()), points);
  const auto neighbours = static_cast<size_t>(k) + 1;  // the sample itself is found too
  std::vector<size_t> index(neighbours);
  std::vector<double> squared(neighbours);
  std::vector<double> query(static_cast<size_t>(samples.rows()));
  double sum_log_distance = 0;
  for (Eigen::Index i = 0; i < samples.cols(); ++i) {
    for (Eigen::Index row = 0; row < samples.rows(); ++row) {
      query[static_cast<size_t>(row)] = samples(row, i);
    }
    tree.knnSearch(query.data(), neighbours, index.data(), squared.data());
    if (!(squared.back() > 0)) return {0, "samples repeat more than k times: no density"};
    sum_log_distance += std::log(squared.back()) / 2;
  }
  const auto n = static_cast<double>(samples.cols());
  const auto d = static_cast<double>(samples.rows());
  return {d * sum_log_distance / n + std::log(n) + log_unit_ball_volume(d) - digamma(double(k)),
          ""};
}

}  // namespace infuse::study

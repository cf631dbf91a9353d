#include "tests/study/dependence/distance_correlation.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "fusion/dependence/sample_choice.hpp"

namespace infuse::study {
namespace {

using namespace dependence;
using Eigen::Index;
using Eigen::VectorXd;

// Sums over the distances a_ij = |x_i − x_j|, b_ij = |y_i − y_j|.
struct DistanceSums {
  VectorXd row_a, row_b;                                  // Σ_j a_ij, Σ_j b_ij
  double product_ab = 0, product_aa = 0, product_bb = 0;  // Σ_ij a_ij b_ij, …
};

std::vector<int> argsort(const VectorXd& values) {
  std::vector<int> order(static_cast<size_t>(values.size()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return values[i] < values[j]; });
  return order;
}

// Σ_j |v_i − v_j| for all i, from the sorted order.
VectorXd distance_rows(const VectorXd& values, const std::vector<int>& order) {
  VectorXd rows(values.size());
  const double n = static_cast<double>(values.size()), total = values.sum();
  double below = 0, count = 0;  // sum and number of the smaller values
  for (const int i : order) {
    rows[i] = values[i] * (2 * count - n) + total - 2 * below;
    below += values[i];
    count += 1;
  }
  return rows;
}

// Prefix sums of 1, x, y and xy over ranks, in a binary indexed tree.
struct PairSums {
  double n = 0, x = 0, y = 0, xy = 0;
  void add(const PairSums& o) { n += o.n, x += o.x, y += o.y, xy += o.xy; }
};
class RankTree {
 public:
  explicit RankTree(size_t n) : nodes_(n + 1) {}
  void insert(size_t rank, const PairSums& entry) {
    for (size_t k = rank + 1; k < nodes_.size(); k += k & (~k + 1)) nodes_[k].add(entry);
  }
  PairSums sum_below(size_t rank) const {
    PairSums sums;
    for (size_t k = rank; k > 0; k -= k & (~k + 1)) sums.add(nodes_[k]);
    return sums;
  }

 private:
  std::vector<PairSums> nodes_;
};

// Visits the samples in order of x; |y_i − y_j| is y_i − y_j where y_j has the lower rank. Huo and
// Székely 2016, with a tree instead of the merge sort.
double product_sum(const VectorXd& x, const VectorXd& y, const std::vector<int>& by_x,
                   const std::vector<int>& by_y) {
  std::vector<size_t> rank(by_y.size());
  for (size_t k = 0; k < by_y.size(); ++k) rank[static_cast<size_t>(by_y[k])] = k;
  RankTree tree(by_y.size());
  PairSums all;
  const auto signed_sum = [](const PairSums& s, double xi, double yi) {
    return xi * yi * s.n - xi * s.y - yi * s.x + s.xy;  // Σ (x_i − x_j)(y_i − y_j)
  };
  double sum = 0;
  for (const int i : by_x) {
    const size_t r = rank[static_cast<size_t>(i)];
    sum += 2 * signed_sum(tree.sum_below(r), x[i], y[i]) - signed_sum(all, x[i], y[i]);
    const PairSums entry{1, x[i], y[i], x[i] * y[i]};
    tree.insert(r, entry);
    all.add(entry);
  }
  return 2 * sum;
}

DistanceSums scalar_sums(VectorXd x, VectorXd y) {
  x.array() -= x.mean();
  y.array() -= y.mean();
  const std::vector<int> by_x = argsort(x), by_y = argsort(y);
  const double n = static_cast<double>(x.size());
  DistanceSums sums{distance_rows(x, by_x), distance_rows(y, by_y)};
  sums.product_ab = product_sum(x, y, by_x, by_y);
  sums.product_aa = 2 * n * x.squaredNorm() - 2 * x.sum() * x.sum();
  sums.product_bb = 2 * n * y.squaredNorm() - 2 * y.sum() * y.sum();
  return sums;
}

DistanceSums vector_sums(const Samples& x, const Samples& y) {
  const Eigen::MatrixXd xt = x.transpose(), yt = y.transpose();
  DistanceSums sums{VectorXd::Zero(x.rows()), VectorXd::Zero(y.rows())};
  for (Index i = 0; i < x.rows(); ++i) {
    for (Index j = 0; j < i; ++j) {
      const double a = (xt.col(i) - xt.col(j)).norm(), b = (yt.col(i) - yt.col(j)).norm();
      sums.row_a[i] += a;
      sums.row_a[j] += a;
      sums.row_b[i] += b;
      sums.row_b[j] += b;
      sums.product_ab += 2 * a * b;
      sums.product_aa += 2 * a * a;
      sums.product_bb += 2 * b * b;
    }
  }
  return sums;
}

// Mean product of the doubly centred distances: dCov² from its three sums.
double centred(double product, const VectorXd& a, const VectorXd& b) {
  const double n = static_cast<double>(a.size());
  return product / (n * n) - 2 * a.dot(b) / (n * n * n) + a.sum() * b.sum() / (n * n * n * n);
}

// The same with unbiased centring (U-centring), times a factor that cancels in the correlation.
double centred_without_bias(double product, const VectorXd& a, const VectorXd& b) {
  const double n = static_cast<double>(a.size());
  return product - 2 * a.dot(b) / (n - 2) + a.sum() * b.sum() / ((n - 1) * (n - 2));
}

}  // namespace

DistanceDependence distance_dependence(const Samples& x, const Samples& y) {
  DistanceDependence result;
  result.reason = check_paired_samples(x, y);
  if (!result.usable()) return result;
  // Division by the largest entry keeps the squares of finite values in range.
  const double scale_x = x.cwiseAbs().maxCoeff(), scale_y = y.cwiseAbs().maxCoeff();
  const Eigen::MatrixXd u = x / scale_x, v = y / scale_y;
  const DistanceSums sums =
      u.cols() == 1 && v.cols() == 1 ? scalar_sums(u.col(0), v.col(0)) : vector_sums(u, v);

  const double covariance = std::max(0.0, centred(sums.product_ab, sums.row_a, sums.row_b));
  const double variances = centred(sums.product_aa, sums.row_a, sums.row_a) *
                           centred(sums.product_bb, sums.row_b, sums.row_b);
  if (!(variances > 0)) {
    result.reason = "the samples vary too little";
    return result;
  }
  result.covariance = std::sqrt(covariance) * std::sqrt(scale_x) * std::sqrt(scale_y);
  result.correlation = std::min(1.0, std::sqrt(covariance / std::sqrt(variances)));
  if (x.rows() < 4) return result;
  const double corrected_variances = centred_without_bias(sums.product_aa, sums.row_a, sums.row_a) *
                                     centred_without_bias(sums.product_bb, sums.row_b, sums.row_b);
  if (corrected_variances > 0) {
    result.corrected_correlation = centred_without_bias(sums.product_ab, sums.row_a, sums.row_b) /
                                   std::sqrt(corrected_variances);
  }
  return result;
}

Estimate distance_correlation(const Samples& x, const Samples& y) {
  const DistanceDependence result = distance_dependence(x, y);
  return {result.correlation, result.reason};
}

Estimate corrected_distance_correlation(const Samples& x, const Samples& y) {
  const DistanceDependence result = distance_dependence(x, y);
  if (result.usable() && x.rows() < 4) return {0, "fewer than four samples"};
  return {result.corrected_correlation, result.reason};
}

}  // namespace infuse::study

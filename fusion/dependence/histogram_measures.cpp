#include "fusion/dependence/histogram_measures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "fusion/dependence/count_entropy.hpp"

namespace infuse::dependence {
namespace {

/// Row and column sums, on the stack.
struct Marginals {
  std::array<double, kMaxBins> x{}, y{};
};

Marginals sum_marginals(std::span<const double> table, size_t bins_x, size_t bins_y) {
  Marginals sums;
  for (size_t i = 0; i < bins_x; ++i) {
    for (size_t j = 0; j < bins_y; ++j) {
      sums.x[i] += table[i * bins_y + j];
      sums.y[j] += table[i * bins_y + j];
    }
  }
  return sums;
}

bool is_entropy_measure(Measure which) {
  return which == Measure::kMutualInformation || which == Measure::kNormalisedMutualInformation;
}

}  // namespace

Estimate measure(Measure which, const JointHistogram& histogram) {
  const double total = histogram.total;
  if (!(total > 0)) return {0, histogram.usable() ? "no samples" : histogram.reason};
  const auto bins_x = static_cast<size_t>(histogram.bins_x);
  const auto bins_y = static_cast<size_t>(histogram.bins_y);
  const Marginals sums = sum_marginals(histogram.mass, bins_x, bins_y);
  if (is_entropy_measure(which)) {
    // H = ln W − (Σ m ln m)/W, so that the table needs no normalised copy.
    const auto compute_entropy = [total](std::span<const double> mass) {
      double sum = 0;
      for (const double m : mass) sum += m > 0 ? m * std::log(m) : 0;
      return std::log(total) - sum / total;
    };
    const double x = compute_entropy({sums.x.data(), bins_x});
    const double y = compute_entropy({sums.y.data(), bins_y});
    const double xy = std::clamp(compute_entropy(histogram.mass), std::max({x, y, 0.0}),
                                 std::max(x + y, 0.0));  // against rounding
    if (which == Measure::kMutualInformation) return {x + y - xy, histogram.reason};
    return {xy > 0 ? (x + y) / xy : 1, histogram.reason};
  }
  double ratio = 0;  // Σ p²/(p_x p_y): the total cancels
  for (size_t i = 0; i < bins_x; ++i) {
    for (size_t j = 0; j < bins_y; ++j) {
      const double m = histogram.mass[i * bins_y + j];
      if (m > 0) ratio += m * (m / (sums.x[i] * sums.y[j]));
    }
  }
  const double chi_squared = std::max(0.0, ratio - 1);
  return {which == Measure::kChiSquared ? chi_squared : chi_squared / 2, histogram.reason};
}

void differentiate(Measure which, const JointHistogram& histogram, Sensitivity& out) {
  out.estimate = measure(which, histogram);
  out.total = histogram.total;
  out.table.assign(histogram.mass.size(), 0.0);
  if (!(histogram.total > 0)) return;
  const auto bins_x = static_cast<size_t>(histogram.bins_x);
  const auto bins_y = static_cast<size_t>(histogram.bins_y);
  const double scale = 1 / histogram.total;
  Marginals p = sum_marginals(histogram.mass, bins_x, bins_y);
  for (double& m : p.x) m *= scale;
  for (double& m : p.y) m *= scale;

  if (is_entropy_measure(which)) {
    // dI/dp = ln p − ln p_y; dNMI follows from (H_x + H_y)/H_xy.
    const double h_x = plug_in_entropy({p.x.data(), bins_x});
    const double h_y = plug_in_entropy({p.y.data(), bins_y});
    double h_xy = 0;
    std::array<double, kMaxBins> log_y{};
    for (size_t j = 0; j < bins_y; ++j) log_y[j] = p.y[j] > 0 ? std::log(p.y[j]) : 0;
    for (size_t k = 0; k < out.table.size(); ++k) {
      const double q = histogram.mass[k] * scale;
      out.table[k] = q > 0 ? std::log(q) : 0;
      h_xy -= q * out.table[k];
    }
    double joint = 1, marginal = 1;  // factors of ln p and of −ln p_y
    if (which == Measure::kNormalisedMutualInformation) {
      marginal = h_xy > 0 ? 1 / h_xy : 0;
      joint = h_xy > 0 ? (h_x + h_y) / (h_xy * h_xy) : 0;
    }
    for (size_t k = 0; k < out.table.size(); ++k) {
      if (histogram.mass[k] > 0) {
        out.table[k] = joint * out.table[k] - marginal * log_y[k % bins_y];
      }
    }
    return;
  }
  const double factor = which == Measure::kChiSquared ? 1 : 0.5;
  for (size_t j = 0; j < bins_y; ++j) {
    double column = 0;  // Σ_x p²/(p_x p_y²)
    for (size_t i = 0; i < bins_x; ++i) {
      const double q = histogram.mass[i * bins_y + j] * scale;
      if (q > 0) column += (q / p.y[j]) * (q / p.y[j]) / p.x[i];
    }
    for (size_t i = 0; i < bins_x; ++i) {
      const double q = histogram.mass[i * bins_y + j] * scale;
      if (q > 0) out.table[i * bins_y + j] = factor * (2 * (q / p.y[j]) / p.x[i] - column);
    }
  }
}

}  // namespace infuse::dependence

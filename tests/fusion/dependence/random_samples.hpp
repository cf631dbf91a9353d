#pragma once

#include <Eigen/Core>
#include <cmath>
#include <random>

namespace infuse::dependence {

/// Returns n × d independent standard normal numbers.
inline Eigen::MatrixXd normal_samples(Eigen::Index n, Eigen::Index d, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(n, d, [&]() { return normal(random); });
}

/// Returns standard normal numbers with correlation `rho` to each column of `x`.
inline Eigen::MatrixXd correlated_with(const Eigen::MatrixXd& x, double rho, uint64_t seed) {
  return rho * x + std::sqrt(1 - rho * rho) * normal_samples(x.rows(), x.cols(), seed);
}

/// Derivative of `value(samples)` with respect to each entry, by central differences.
template <class Value>
Eigen::MatrixXd central_differences(const Value& value, const Eigen::MatrixXd& samples,
                                    double step) {
  Eigen::MatrixXd moved = samples, gradient(samples.rows(), samples.cols());
  for (Eigen::Index i = 0; i < samples.size(); ++i) {
    moved(i) = samples(i) + step;
    const double above = moved(i), up = value(moved);
    moved(i) = samples(i) - step;
    gradient(i) = (up - value(moved)) / (above - moved(i));
    moved(i) = samples(i);
  }
  return gradient;
}

/// Running mean and its standard error.
class RunningMean {
 public:
  void add(double value) {
    ++n_;
    sum_ += value;
    squares_ += value * value;
  }
  double mean() const { return sum_ / n_; }
  double standard_error() const {
    return std::sqrt(std::max(0.0, squares_ / n_ - mean() * mean()) / (n_ - 1));
  }

 private:
  double n_ = 0, sum_ = 0, squares_ = 0;
};

}  // namespace infuse::dependence

#include "fusion/dependence/gaussian_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "drivers/measurement/simd.hpp"
#include "fusion/dependence/lanes.hpp"
#include "fusion/dependence/matrix_product.hpp"

namespace infuse::dependence {
namespace {

using Eigen::Index;

// Replaces x by exp(x) for x <= 0, within 2 units in the last place: x = k·ln 2 + r, |r| <= ln 2 /
// 2, exp(r) by its Taylor series to r¹³ (remainder below 5e-18), 2^k by the exponent bits.
template <class Set>
[[gnu::always_inline]] inline void exp_of_negative(typename Set::Vector& x) {
  using Vector = typename Set::Vector;
  using Integers = typename Set::Integers;
  constexpr double kRoundToInteger = 6755399441055744.0;  // 1.5·2^52: adding it rounds to an
                                                          // integer
  // ln 2 in two parts: the product of the first with k is exact in double precision.
  constexpr double kLn2High = 0x1.62e42fefa0000p-1, kLn2Low = 0x1.cf79abc9e3b3ap-40;
  constexpr double kMinArgument = -707.0;  // below −708 exp underflows
  const Integers in_range = x >= kMinArgument;
  const Vector clamped = in_range ? x : Vector{} + kMinArgument;
  const Vector shifted = clamped * std::numbers::log2e + kRoundToInteger;
  const Vector k = shifted - kRoundToInteger;
  const Vector r = (clamped - k * kLn2High) - k * kLn2Low;
  Vector p = r * (1.0 / 6227020800.0) + 1.0 / 479001600.0;
  p = p * r + 1.0 / 39916800.0;
  p = p * r + 1.0 / 3628800.0;
  p = p * r + 1.0 / 362880.0;
  p = p * r + 1.0 / 40320.0;
  p = p * r + 1.0 / 5040.0;
  p = p * r + 1.0 / 720.0;
  p = p * r + 1.0 / 120.0;
  p = p * r + 1.0 / 24.0;
  p = p * r + 1.0 / 6.0;
  p = p * r + 0.5;
  p = p * r + 1.0;
  p = p * r + 1.0;
  const Vector scaled = (Vector)((Integers)p + ((Integers)shifted << 52));
  x = in_range ? scaled : Vector{};
}

// Kernel values of one sample (features `stride` apart) at Set::kLanes centres.
template <class Set>
[[gnu::always_inline]] inline void kernel_block(const double* sample, Index stride,
                                                const double* centres, Index centre_count,
                                                Index dimensions, double factor, double* out) {
  typename Set::Vector sum = {};
  for (Index f = 0; f < dimensions; ++f) {
    typename Set::Vector difference;
    std::memcpy(&difference, centres + f * centre_count, sizeof(difference));
    difference = difference - sample[f * stride];
    sum += difference * difference;
  }
  sum *= factor;
  exp_of_negative<Set>(sum);
  std::memcpy(out, &sum, sizeof(sum));
}

// The last block of a row overlaps the one before it if the number of centres is not a multiple of
// the lanes.
template <class Set>
[[gnu::always_inline]] inline void kernel_with(const Samples& samples, const double* centres,
                                               Index centre_count, double factor, double* kernel) {
  const Index dimensions = samples.cols(), stride = samples.outerStride();
  for (Index i = 0; i < samples.rows(); ++i) {
    const double* sample = samples.data() + i;
    double* out = kernel + i * centre_count;
    if (centre_count < Set::kLanes) {
      for (Index l = 0; l < centre_count; ++l) {
        kernel_block<Lanes<1>>(sample, stride, centres + l, centre_count, dimensions, factor,
                               out + l);
      }
      continue;
    }
    for (Index block = 0; block < centre_count; block += Set::kLanes) {
      const Index l = std::min<Index>(block, centre_count - Set::kLanes);
      kernel_block<Set>(sample, stride, centres + l, centre_count, dimensions, factor, out + l);
    }
  }
}

void kernel_baseline(const Samples& samples, const double* centres, Index centre_count,
                     double factor, double* kernel) {
  kernel_with<Lanes<2>>(samples, centres, centre_count, factor, kernel);
}

INFUSE_TARGET("avx2")
void kernel_avx2(const Samples& samples, const double* centres, Index centre_count, double factor,
                 double* kernel) {
  kernel_with<Lanes<4>>(samples, centres, centre_count, factor, kernel);
}

INFUSE_TARGET("arch=x86-64-v4")
void kernel_avx512(const Samples& samples, const double* centres, Index centre_count, double factor,
                   double* kernel) {
  kernel_with<Lanes<8>>(samples, centres, centre_count, factor, kernel);
}

}  // namespace

void gaussian_kernel(const Samples& samples, const Samples& centres, double sigma,
                     Eigen::MatrixXd& kernel, InstructionSet set) {
  kernel.resize(centres.rows(), samples.rows());
  gaussian_kernel(samples, Eigen::MatrixXd(centres), sigma, kernel.data(), set);
}

void gaussian_kernel(const Samples& samples, const Eigen::MatrixXd& centres, double sigma,
                     double* kernel, InstructionSet set) {
  const double factor = -0.5 / (sigma * sigma);
  select_variant(set, kernel_baseline, kernel_avx2, kernel_avx512)(samples, centres.data(),
                                                                   centres.rows(), factor, kernel);
}

void gaussian_overlap(const Samples& centres, double sigma, Eigen::MatrixXd& overlap) {
  gaussian_kernel(centres, centres, sigma * std::numbers::sqrt2, overlap);
  overlap *= std::pow(std::numbers::pi * sigma * sigma, 0.5 * static_cast<double>(centres.cols()));
}

void gaussian_kernel_gradient(const Samples& samples, const std::vector<int>& centre_rows,
                              double sigma, const Eigen::MatrixXd& kernel,
                              Eigen::MatrixXd& sensitivity, Eigen::MatrixXd& gradient) {
  // ∂kernel(l, i) = −kernel(l, i)·(x_i − c_l)·(∂x_i − ∂c_l)/σ². The sums over (x − c) are split
  // into products with [x 1] and [c 1]; centring the samples avoids cancellation.
  sensitivity.array() *= kernel.array() / (sigma * sigma);
  const Index d = samples.cols();
  Eigen::MatrixXd x(samples.rows(), d + 1);
  x.leftCols(d) = samples.rowwise() - samples.colwise().mean();
  x.col(d).setOnes();
  Eigen::MatrixXd c(kernel.rows(), d + 1);
  for (Index l = 0; l < c.rows(); ++l) c.row(l) = x.row(centre_rows[static_cast<size_t>(l)]);

  Eigen::MatrixXd by_sample, by_centre;
  multiply(sensitivity.transpose(), c, by_sample);
  multiply(sensitivity, x, by_centre);
  gradient = by_sample.leftCols(d);
  for (Index f = 0; f < d; ++f) gradient.col(f) -= by_sample.col(d).cwiseProduct(x.col(f));
  for (Index l = 0; l < c.rows(); ++l) {
    gradient.row(centre_rows[static_cast<size_t>(l)]) +=
        by_centre.row(l).head(d) - by_centre(l, d) * c.row(l).head(d);
  }
}

}  // namespace infuse::dependence

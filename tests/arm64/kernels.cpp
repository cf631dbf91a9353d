// Prints the results of the vector kernels of fusion/dependence as bits: the same on every
// processor.
#include <bit>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "fusion/dependence/column_sums.hpp"
#include "fusion/dependence/gaussian_kernel.hpp"
#include "fusion/dependence/matrix_product.hpp"

namespace {

using Eigen::Index;

/// Numbers between -1 and 1 that need no function of a library.
Eigen::MatrixXd numbers(Index rows, Index columns, uint64_t seed) {
  Eigen::MatrixXd out(rows, columns);
  for (Index i = 0; i < out.size(); ++i) {
    seed = seed * 6364136223846793005U + 1442695040888963407U;
    out.data()[i] = static_cast<double>(static_cast<int64_t>(seed)) * 0x1p-63;
  }
  return out;
}

void print(const char* name, const double* values, Index count) {
  uint64_t hash = 0xcbf29ce484222325;
  for (Index i = 0; i < count; ++i)
    hash = (hash ^ std::bit_cast<uint64_t>(values[i])) * 0x100000001b3;
  std::printf("%s %ld numbers %016lx\n", name, static_cast<long>(count),
              static_cast<unsigned long>(hash));
}

}  // namespace

int main() {
  using namespace infuse;
  const Eigen::MatrixXd a = numbers(53, 131, 1), b = numbers(131, 29, 2),
                        samples = numbers(97, 2, 3);
  Eigen::MatrixXd out;
  dependence::multiply(a, b, out);
  print("product", out.data(), out.size());
  dependence::multiply_by_transpose(a, out);
  print("product with the transpose", out.data(), out.size());
  dependence::gaussian_kernel(samples, samples.topRows(31), 0.3, out);
  print("Gaussian kernel", out.data(), out.size());
  std::vector<double> sums(static_cast<size_t>(a.rows()));
  dependence::sum_columns(a, std::vector<int>{0, 7, 3, 130}, sums.data());
  print("column sums", sums.data(), a.rows());
  Eigen::MatrixXd square = a.leftCols(6).transpose() * a.leftCols(6);
  const Eigen::Matrix<double, 6, 6> fixed = square;
  print("Eigen's product of 6 x 6", Eigen::Matrix<double, 6, 6>(fixed * fixed).data(), 36);
}

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

namespace infuse::arithmetic {

/// What one function gives for random arguments.
struct Results {
  std::string name;
  std::vector<double> values;  ///< floats too: no bit is lost
};

/// Random numbers made of integers alone (splitmix64): the same everywhere.
class Numbers {
 public:
  explicit Numbers(uint64_t seed) : state_(seed) {}

  double uniform(double low, double high) {
    state_ += 0x9E3779B97F4A7C15;
    uint64_t z = (state_ ^ (state_ >> 30)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
    return low + (high - low) * (static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53);
  }

  template <class Matrix>
  void fill(Matrix& m) {
    using Scalar = typename Matrix::Scalar;
    for (Eigen::Index c = 0; c < m.cols(); ++c) {
      for (Eigen::Index r = 0; r < m.rows(); ++r) m(r, c) = static_cast<Scalar>(uniform(-2, 2));
    }
  }

 private:
  uint64_t state_;
};

/// Products, decompositions and sums of Eigen.
std::vector<Results> eigen_results();

}  // namespace infuse::arithmetic

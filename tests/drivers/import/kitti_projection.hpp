#pragma once

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "tests/real_data.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::importers {

// Reads the numbers after "KEY:" in a calibration file, independently of the code under test.
inline std::vector<double> numbers_after(const std::filesystem::path& file,
                                         const std::string& key) {
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line)) {
    if (line.rfind(key + ":", 0) != 0) continue;
    std::istringstream words(line.substr(key.size() + 1));
    std::vector<double> numbers;
    for (double number = 0; words >> number;) numbers.push_back(number);
    return numbers;
  }
  return {};
}

// rows × 3 or rows × 4 numbers, extended to 4 × 4 with the identity.
using Matrix = std::array<std::array<double, 4>, 4>;
inline Matrix to_matrix(const std::vector<double>& numbers, size_t columns) {
  Matrix m{};
  for (size_t i = 0; i < 4; ++i) m[i][i] = 1;
  for (size_t i = 0; i < numbers.size(); ++i) m[i / columns][i % columns] = numbers[i];
  return m;
}
inline Matrix multiply(const Matrix& a, const Matrix& b) {
  Matrix m{};
  for (size_t i = 0; i < 4; ++i) {
    for (size_t j = 0; j < 4; ++j) {
      for (size_t k = 0; k < 4; ++k) m[i][j] += a[i][k] * b[k][j];
    }
  }
  return m;
}

// KITTI's projection: P · R0 · Tr · x, divided by the third coordinate.
struct Pixel {
  double u, v, depth;
};
inline Pixel project(const Matrix& chain, double x, double y, double z) {
  const auto row = [&](size_t i) {
    return chain[i][0] * x + chain[i][1] * y + chain[i][2] * z + chain[i][3];
  };
  return {row(0) / row(2), row(1) / row(2), row(2)};
}

}  // namespace infuse::importers

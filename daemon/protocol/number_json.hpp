#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "daemon/protocol/json.hpp"

namespace infuse::daemon {

/// The numbers of a matrix, by row.
template <class Matrix>
Json by_row(const Matrix& matrix) {
  Json numbers = Json::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      numbers.push_back(matrix(row, column));
    }
  }
  return numbers;
}

/// The rows of a matrix.
template <class Matrix>
Json rows_json(const Matrix& matrix) {
  Json rows = Json::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) rows.push_back(by_row(matrix.row(row)));
  return rows;
}

/// The numbers of an array of `count`; nothing if it is anything else.
template <class AnyJson>
std::optional<std::vector<double>> numbers_of(const AnyJson& array, size_t count) {
  if (!array.is_array() || array.size() != count) return std::nullopt;
  std::vector<double> numbers;
  for (const AnyJson& number : array) {
    if (!number.is_number()) return std::nullopt;
    numbers.push_back(number.template get<double>());
  }
  return numbers;
}

}  // namespace infuse::daemon
